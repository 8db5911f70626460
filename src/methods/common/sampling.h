// Stages that every sample-based method shares: start point, candidates, points (thinning.h),
// cells, samples, albedo.
#pragma once

#include "methods/common/thinning.h"
#include "methods/method.h"

namespace prt {

/// Ids of the stages' last tasks.
inline constexpr const char* kSamplesTask = "samples";
inline constexpr const char* kAlbedoTask = "albedo";

/// Colour channels that light needs on surfaces of that artifact of kAlbedoTask: one serves all
/// three where they are grey.
int colour_channels(const Artifact& albedo);

/// Adds the sampling stages to the plan, as far as results allow. Returns true once "samples" is
/// finished; "albedo" is planned beside it.
bool plan_sampling(const PlanInputs& inputs, Plan& plan, const ThinningSplit& split = {});

/// How far the stages split for about so many samples.
struct SamplingTasks {
  double candidates = 0.0;
  double candidate_tasks = 1.0;
  double tiles = 1.0;  ///< 1: one task thins all, and the next is not there
  double sorting_tasks = 0.0;
  double cell_points = 0.0;
  double cell_tasks = 1.0;
};
SamplingTasks sampling_tasks(double samples);

/// Samples that a bake of `options` has on `area` m² of reachable surface, about.
double expected_samples(const OptionValues& options, double area);

std::vector<std::string> sampling_kinds();
Artifact run_sampling(const TaskSpec& task, const TaskReader& reader);

}  // namespace prt
