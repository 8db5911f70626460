// What the stages of methods/common amount to.
#pragma once

#include "methods/options.h"
#include "methods/work.h"

namespace prt {

std::vector<StageWork> sampling_and_rays_work(const BakeSize& size, const OptionValues& options);

}  // namespace prt
