// The method's stages, as far as finished results allow.
#pragma once

#include "methods/method.h"

namespace prt::lb {

Plan make_plan(const PlanInputs& inputs);

}  // namespace prt::lb
