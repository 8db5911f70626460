// prt_eval with environments: how wrong a package is under them.
#pragma once

#include "apps/prt_eval_command.h"

namespace prt {

/// Measures and prints or writes the figures. Throws std::runtime_error if a value is not finite,
/// UserError where the package has no environment layer.
void report_sky_error(const EvalCommand& command);

}  // namespace prt
