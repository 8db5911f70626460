// The bake measures its own error in ordinary tasks: one path-traced reference per test light
// ("reference/0003", needs only the samples) and one comparison ("evaluate", needs the package's
// parts).
#pragma once

#include <string>
#include <vector>

#include "methods/method.h"

namespace prt {

/// The tasks of options evaluate.{lights, points, spp} and seed. References are planned as soon as
/// `samples_task` is; `package_results` are the method's Plan::results once its plan is complete,
/// null before. Then the plan is complete too and results is {"evaluate"}. With lights or points 0
/// there are no tasks, and left_out says so.
Plan plan_evaluation(const OptionValues& options, const std::string& samples_task,
                     const std::vector<std::string>* package_results);

/// Kinds of task planned above: "reference", "evaluate".
std::vector<std::string> evaluation_kinds();

/// What these tasks amount to in a bake of that size.
std::vector<StageWork> evaluation_work(const BakeSize& size, const OptionValues& options);

/// Runs a "reference" task: inputs {samples}; reads geometry and materials. Throws Interrupted when
/// asked to stop, UserError where no light fits in.
Artifact run_reference(const TaskSpec& task, const TaskReader& reader);

/// Runs the "evaluate" task. Inputs: first the references, parameters["references"] of them, then
/// package_results in their order. `package` is what Method::assemble makes of those results (the
/// scene is not needed). The artifact's attribute "error" is the JSON of summarise(). Throws
/// UnsoundData when a value is not finite.
Artifact run_evaluate(const TaskSpec& task, const TaskReader& reader, const Package& package);

/// Error JSON as in prt_eval --json, for Package::error and the report: the keys of design §3 but
/// for package_bytes, bake_seconds and play_ms. `evaluate` is the artifact of the "evaluate" task,
/// in a scene of that origin; the JSON is in the world.
nlohmann::json summarise(const Artifact& evaluate, const Vec3d& origin);

}  // namespace prt
