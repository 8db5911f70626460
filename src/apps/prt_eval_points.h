// prt_eval's other two forms: irradiance at given points, played or path traced.
#pragma once

#include "apps/prt_eval_command.h"

namespace prt {

/// Reads the points, evaluates and writes them. Points that no splat reaches become `nan` and are
/// counted on stderr. Throws std::runtime_error if another value is not finite.
void evaluate_points(const EvalCommand& command);

}  // namespace prt
