#include "apps/bake/report.h"

#include <algorithm>
#include <map>

namespace prt {

namespace {

using nlohmann::json;

/// Mean and largest value of each figure (measured errors, ranks) over a stage's tasks.
json summarise_figures(const std::vector<const TaskHistory*>& tasks) {
  struct Sum {
    double total = 0.0;
    double largest = 0.0;
    std::size_t count = 0;
  };
  std::map<std::string, Sum> sums;
  for (const TaskHistory* task : tasks) {
    for (const auto& [name, value] : task->figures.items()) {
      Sum& sum = sums[name];
      const double v = value.get<double>();
      sum.largest = sum.count == 0 ? v : std::max(sum.largest, v);
      sum.total += v;
      ++sum.count;
    }
  }
  json figures = json::object();
  for (const auto& [name, sum] : sums) {
    figures[name] = {{"mean", sum.total / static_cast<double>(sum.count)}, {"max", sum.largest}};
  }
  return figures;
}

json describe_stage(const std::string& name, const std::vector<const TaskHistory*>& tasks,
                    const BakePrediction* prediction) {
  std::size_t made = 0;
  double seconds = 0.0;
  double cpu_seconds = 0.0;
  std::uint64_t bytes = 0;
  for (const TaskHistory* task : tasks) {
    made += task->made ? 1 : 0;
    seconds += task->cost.seconds;
    cpu_seconds += task->cost.cpu_seconds;
    bytes += task->cost.bytes;
  }
  const StagePrediction* predicted = nullptr;
  if (prediction != nullptr) {
    for (const StagePrediction& stage : prediction->stages) {
      if (stage.stage == name) predicted = &stage;
    }
  }
  const auto foretold = [&](double StagePrediction::*part) {
    return predicted != nullptr ? json(predicted->*part) : json(nullptr);
  };
  return {{"stage", name},
          {"tasks", tasks.size()},
          {"made", made},
          {"found", tasks.size() - made},
          {"predicted_seconds", foretold(&StagePrediction::seconds)},
          {"predicted_bytes", foretold(&StagePrediction::bytes)},
          {"predicted_rays", foretold(&StagePrediction::rays)},
          {"seconds", seconds},
          {"cpu_seconds", cpu_seconds},
          {"bytes", bytes},
          {"measured", summarise_figures(tasks)}};
}

json describe_stages(const Plan& plan, const History& history, const BakePrediction* prediction) {
  std::map<std::string, std::vector<const TaskHistory*>> by_stage;
  for (const TaskHistory& task : history.tasks()) by_stage[task.stage].push_back(&task);
  std::vector<std::string> order;
  for (const TaskSpec& task : plan.tasks) {
    if (std::ranges::count(order, task.kind) == 0) order.push_back(task.kind);
  }
  json stages = json::array();
  for (const std::string& stage : order) {
    stages.push_back(describe_stage(stage, by_stage[stage], prediction));
  }
  return stages;
}

json describe_scene(const BakeConfig& config, const Scene& scene) {
  return {{"file", config.scene.string()},
          {"origin", origin_of(scene)},
          {"vertex_rounding", scene.vertex_rounding},
          {"triangles", scene.triangles.size()},
          {"materials", scene.materials.size()},
          {"textures", scene.textures.size()},
          {"geometry_hash", scene.geometry_hash.hex()},
          {"materials_hash", scene.materials_hash.hex()},
          {"lights_hash", scene.lights_hash.hex()},
          {"repairs", scene.repairs.total()},
          {"repair_notes", scene.repairs.notes}};
}

}  // namespace

json origin_of(const Scene& scene) {
  return {scene.origin.x(), scene.origin.y(), scene.origin.z()};
}

json make_report(const ReportFacts& facts, const History& history) {
  json options = json::object();
  for (const auto& [key, value] : facts.plan.options.all()) options[key] = value;
  json left_out = json::array();
  for (const LeftOut& l : facts.plan.all.left_out) {
    left_out.push_back({{"what", l.what}, {"reason", l.reason}});
  }
  return {{"schema_version", 1},
          {"complete", true},
          {"method", facts.config.method->name()},
          {"options", options},
          {"scene", describe_scene(facts.config, facts.scene)},
          {"stages", describe_stages(facts.plan.all, history, facts.prediction)},
          {"survey", facts.survey},
          {"left_out", left_out},
          {"error", facts.error},
          {"accuracy", facts.plan.accuracy},
          {"package", facts.package},
          {"package_bytes", facts.package_bytes},
          {"package_content", facts.package_content.hex()},
          {"bake_seconds", facts.wall_seconds + history.earlier_seconds()},
          {"this_run",
           {{"seconds", facts.wall_seconds},
            {"cpu_seconds", facts.cpu_seconds},
            {"tasks_made", history.made()},
            {"tasks_found", history.tasks().size() - history.made()},
            {"ranks", facts.ranks},
            {"threads", facts.threads},
            {"hosts", facts.hosts},
            {"instruction_set", facts.isa}}}};
}

}  // namespace prt
