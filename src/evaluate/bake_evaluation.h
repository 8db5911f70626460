// The bake measures its own error in ordinary tasks: one path-traced reference per test light
// ("reference/0003", needs only the samples), comparisons of some of them each ("compare/0000",
// need the package's parts) and the figures of all ("evaluate").
#pragma once

#include <string>
#include <vector>

#include "methods/method.h"
#include "player/evaluator.h"

namespace prt {

/// The tasks of options evaluate.{lights, points, spp} and seed. References are planned as soon as
/// `samples_task` is; `package_results` are the method's Plan::results once its plan is complete,
/// null before. Then the plan is complete too and results is {"evaluate"}. With lights or points 0
/// there are no tasks, and left_out says so.
Plan plan_evaluation(const OptionValues& options, const std::string& samples_task,
                     const std::vector<std::string>* package_results);

/// Kinds of task planned above: "reference", "compare", "evaluate".
std::vector<std::string> evaluation_kinds();

/// What these tasks amount to in a bake of that size.
std::vector<StageWork> evaluation_work(const BakeSize& size, const OptionValues& options);

/// Runs a "reference" task: inputs {samples}; reads geometry and materials. Throws Interrupted when
/// asked to stop, UserError where no light fits in.
Artifact run_reference(const TaskSpec& task, const TaskReader& reader);

/// Runs a "compare" task. Inputs: first the references, parameters["references"] of them, then
/// package_results in their order. `player` plays what Method::assemble makes of those results (the
/// scene is not needed). Throws UnsoundData when a value is not finite.
Artifact run_compare(const TaskSpec& task, const TaskReader& reader, const Evaluator& player);

/// Runs the "evaluate" task: inputs are the comparisons. The artifact's attribute "error" is the
/// JSON of summarise().
Artifact run_evaluate(const TaskSpec& task, const TaskReader& reader);

/// Error JSON as in prt_eval --json, for Package::error and the report: the keys of design §3 but
/// for package_bytes, bake_seconds and play_ms. `evaluate` is the artifact of the "evaluate" task,
/// in a scene of that origin; the JSON is in the world.
nlohmann::json summarise(const Artifact& evaluate, const Vec3d& origin);

}  // namespace prt
