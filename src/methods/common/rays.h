// The stage that casts every hemispherical ray of a bake, one task per cluster; depth buffers,
// gather and environment all read its artifacts.
#pragma once

#include "methods/method.h"

namespace prt {

/// Adds "rays/NNNN" for each cluster; needs a finished "samples". Returns the number of clusters.
std::size_t plan_rays(const PlanInputs& inputs, Plan& plan);

std::vector<std::string> rays_kinds();
Artifact run_rays(const TaskSpec& task, const TaskReader& reader);

}  // namespace prt
