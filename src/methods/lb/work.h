// What the method's stages amount to, for predictions.
#pragma once

#include "methods/options.h"
#include "methods/work.h"

namespace prt::lb {

std::vector<StageWork> stage_work(const BakeSize& size, const OptionValues& options,
                                  const StageFigures& figures);

}  // namespace prt::lb
