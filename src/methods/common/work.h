// What the stages of methods/common amount to.
#pragma once

#include <string>

#include "methods/options.h"
#include "methods/work.h"

namespace prt {

/// A figure that a small bake found; `fallback` where it has none.
double figure(const StageFigures& figures, const std::string& stage, const std::string& name,
              double fallback);

std::vector<StageWork> sampling_and_rays_work(const BakeSize& size, const OptionValues& options);

}  // namespace prt
