// What the method's stages amount to.
#pragma once

#include "methods/method.h"

namespace prt::sh {

/// As Method::work.
std::vector<StageWork> stage_work(const BakeSize& size, const OptionValues& options,
                                  const StageFigures& figures);

}  // namespace prt::sh
