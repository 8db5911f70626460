// Self-check of the simulation against cases with known answers.
#pragma once

namespace prt::scaling {

/// Prints what is wrong; returns how many things are.
int check_simulation();

}  // namespace prt::scaling
