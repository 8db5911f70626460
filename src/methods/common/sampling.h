// Stages that every sample-based method shares: start point, candidates, points, cells, samples,
// albedo.
#pragma once

#include "methods/method.h"

namespace prt {

/// Ids of the stages' last tasks.
inline constexpr const char* kSamplesTask = "samples";
inline constexpr const char* kAlbedoTask = "albedo";

/// Adds the sampling stages to the plan, as far as results allow. Returns true once "samples" is
/// finished; "albedo" is planned beside it.
bool plan_sampling(const PlanInputs& inputs, Plan& plan);

std::vector<std::string> sampling_kinds();
Artifact run_sampling(const TaskSpec& task, const TaskReader& reader);

}  // namespace prt
