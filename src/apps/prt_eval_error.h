// prt_eval's first form: how wrong a package is.
#pragma once

#include "apps/prt_eval_command.h"

namespace prt {

/// Measures and prints or writes the figures. Throws std::runtime_error if a value is not finite.
void report_package_error(const EvalCommand& command);

}  // namespace prt
