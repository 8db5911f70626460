// The method's stages, as far as finished results allow.
#pragma once

#include "methods/method.h"

namespace prt::lb {

/// Rounds of snapshot bases at most; those after the first are called "transfer-2" and so on.
inline constexpr int kMostRounds = 4;

Plan make_plan(const PlanInputs& inputs);

}  // namespace prt::lb
