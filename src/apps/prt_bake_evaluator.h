// The bake's measurement of its own error, over src/evaluate.
#pragma once

#include <memory>

#include "apps/bake/evaluator.h"

namespace prt {

std::shared_ptr<const BakeErrorMeter> make_bake_evaluator();

}  // namespace prt
