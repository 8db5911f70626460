// The bake measures its error under environments: one path-traced reference per test environment
// ("sky_reference/0001", needs only the samples) and the figures of all ("sky_evaluate", needs the
// package's parts).
#pragma once

#include <string>
#include <vector>

#include "methods/method.h"
#include "player/evaluator.h"
#include "scene/environment.h"

namespace prt {

/// Test environment `number` of a seed that no bake uses: broad lobes of random colours and
/// directions over a dim sky. As smooth as what spherical harmonics of some order are for.
Environment draw_test_environment(std::uint64_t seed, std::size_t number);

/// As plan_evaluation(), of options evaluate.{environments, points, spp} and seed; results is
/// {"sky_evaluate"}.
Plan plan_sky_evaluation(const OptionValues& options, const std::string& samples_task,
                         const std::vector<std::string>* package_results);

/// "sky_reference", "sky_evaluate".
std::vector<std::string> sky_evaluation_kinds();
std::vector<StageWork> sky_evaluation_work(const BakeSize& size, const OptionValues& options);

/// Inputs {samples}; reads geometry and materials.
Artifact run_sky_reference(const TaskSpec& task, const TaskReader& reader);

/// Inputs: the references, parameters["references"] of them, then package_results. The artifact's
/// attribute "error" is {"environment": sky_error_report()}. Throws UnsoundData when a value is not
/// finite.
Artifact run_sky_evaluate(const TaskSpec& task, const TaskReader& reader, const Evaluator& player);

}  // namespace prt
