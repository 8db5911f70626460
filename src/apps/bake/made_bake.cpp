#include "apps/bake/made_bake.h"

#include <algorithm>
#include <cmath>

namespace prt {

namespace {

std::map<std::string, StageWork> work_of(const BakeProgram& program, const Method& method,
                                         const BakeSize& size, const OptionValues& options,
                                         const StageFigures& figures) {
  std::vector<StageWork> all = method.work(size, options, figures);
  if (program.evaluator) {
    const auto judged = program.evaluator->work(size, options);
    all.insert(all.end(), judged.begin(), judged.end());
  }
  std::map<std::string, StageWork> by_stage;
  for (const StageWork& work : all) by_stage[work.stage] = work;
  return by_stage;
}

/// What a task costs whatever its work, its file above all: without it a stage of milliseconds
/// would be taken for hours of a bake whose work is a million times as much.
constexpr double kTaskSeconds = 1e-3;

/// Seconds of a stage that took so many, at `ratio` times the work.
double scaled_seconds(double seconds, double tasks, double ratio, double wanted_tasks) {
  const double of_task = std::min(kTaskSeconds, seconds / tasks);
  return (seconds - of_task * tasks) * ratio + of_task * wanted_tasks;
}

double ratio(double wanted, double made) { return made > 0.0 ? wanted / made : 1.0; }

}  // namespace

void MadeStages::add(const std::string& task, const std::string& stage, double seconds,
                     double bytes, const nlohmann::json& figures) {
  if (!sums_.contains(stage)) order_.push_back(stage);
  Sum& sum = sums_[stage];
  sum.seconds += seconds;
  sum.bytes += bytes;
  sum.tasks += 1.0;
  sum.rounds.insert(task.substr(0, task.find('/')));
  for (const auto& [name, value] : figures.items()) sum.figures[name] += value.get<double>();
}

StageFigures MadeStages::figures() const {
  StageFigures all;
  for (const auto& [name, sum] : sums_) {
    for (const auto& [figure, total] : sum.figures) all[name][figure] = total / sum.tasks;
    all[name]["tasks"] = sum.tasks;
    all[name]["rounds"] = static_cast<double>(sum.rounds.size());
  }
  return all;
}

BakeSize size_with(const OptionValues& options, double samples) {
  return {samples,
          std::max(1.0, std::round(samples / options.get<double>("samples.cluster_size")))};
}

std::vector<StagePrediction> scale_bake(const BakeProgram& program, const Method& method,
                                        const MadeBake& made, const BakeSize& size,
                                        const OptionValues& options) {
  StageFigures figures = made.stages.figures();
  for (const auto& [key, value] : made.options.all()) {
    if (value.is_number()) figures["options"][key] = value.get<double>();
  }
  const auto wanted = work_of(program, method, size, options, figures);
  const auto had = work_of(program, method, made.size, made.options, figures);
  std::vector<StagePrediction> stages;
  for (const std::string& name : made.stages.order()) {
    const auto w = wanted.find(name);
    const auto found = had.find(name);
    // A stage that the one size has and the other has not tells nothing.
    if (w == wanted.end() || found == had.end()) continue;
    const StageWork& h = found->second;
    stages.push_back({name, w->second.tasks, w->second.rays,
                      scaled_seconds(made.stages.seconds(name), h.tasks,
                                     ratio(w->second.work, h.work), w->second.tasks),
                      made.stages.bytes(name) * ratio(w->second.bytes, h.bytes), w->second.memory});
  }
  return stages;
}

double seconds_on(int threads, const std::vector<StagePrediction>& stages) {
  double seconds = 0.0;
  for (const StagePrediction& stage : stages) {
    seconds += stage.seconds / std::clamp<double>(threads, 1.0, std::max(1.0, stage.tasks));
  }
  return seconds;
}

}  // namespace prt
