#include "apps/prt_bake_evaluator.h"

#include <algorithm>
#include <map>

#include "evaluate/bake_evaluation.h"
#include "evaluate/sky_evaluation.h"
#include "methods/common/sampling.h"
#include "store/manifest.h"

namespace prt {

namespace {

constexpr const char* kCompareKind = "compare";
constexpr const char* kEvaluateKind = "evaluate";
constexpr const char* kSkyReferenceKind = "sky_reference";
constexpr const char* kSkyEvaluateKind = "sky_evaluate";

/// A package and its player, for all comparisons of a process.
struct Played {
  explicit Played(Package made) : package(std::move(made)), player(package, {.threads = 1}) {}
  Package package;
  Evaluator player;
};

class BakeEvaluator : public BakeErrorMeter {
 public:
  [[nodiscard]] Plan plan(const OptionValues& options, const Plan& method_plan) const override {
    const auto is_samples = [](const TaskSpec& task) { return task.id == kSamplesTask; };
    if (std::ranges::none_of(method_plan.tasks, is_samples)) return {};
    const std::vector<std::string>* results = method_plan.complete ? &method_plan.results : nullptr;
    Plan plan;
    plan.complete = method_plan.complete;
    if (method_plan.plays_lights) plan = plan_evaluation(options, kSamplesTask, results);
    if (method_plan.plays_environment) {
      Plan skies = plan_sky_evaluation(options, kSamplesTask, results);
      std::ranges::move(skies.tasks, std::back_inserter(plan.tasks));
      std::ranges::move(skies.results, std::back_inserter(plan.results));
      std::ranges::move(skies.left_out, std::back_inserter(plan.left_out));
    }
    // The package that is judged depends on options, too, not on artifacts alone.
    for (TaskSpec& task : plan.tasks) {
      const bool plays = task.kind == kCompareKind || task.kind == kSkyEvaluateKind;
      if (plays) task.parameters["options"] = options_of_results(options);
    }
    return plan;
  }

  [[nodiscard]] std::vector<std::string> kinds() const override {
    std::vector<std::string> kinds = evaluation_kinds();
    std::ranges::move(sky_evaluation_kinds(), std::back_inserter(kinds));
    return kinds;
  }

  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader, const Method& method,
                             const OptionValues& options) const override {
    if (task.kind == kCompareKind) {
      return run_compare(task, reader, played(task, reader, method, options)->player);
    }
    if (task.kind == kSkyEvaluateKind) {
      return run_sky_evaluate(task, reader, played(task, reader, method, options)->player);
    }
    if (task.kind == kEvaluateKind) return run_evaluate(task, reader);
    return task.kind == kSkyReferenceKind ? run_sky_reference(task, reader)
                                          : run_reference(task, reader);
  }

  [[nodiscard]] std::vector<StageWork> work(const BakeSize& size,
                                            const OptionValues& options) const override {
    std::vector<StageWork> work = evaluation_work(size, options);
    std::ranges::move(sky_evaluation_work(size, options), std::back_inserter(work));
    return work;
  }

  [[nodiscard]] nlohmann::json error(const Artifact& result, const Vec3d& origin) const override {
    const auto error = result.attribute<nlohmann::json>("error");
    return error.contains("environment") ? error : summarise(result, origin);
  }

 private:
  /// What the task's package plays; made once for all tasks that judge the same one.
  static std::shared_ptr<const Played> played(const TaskSpec& task, const TaskReader& reader,
                                              const Method& method, const OptionValues& options) {
    const std::size_t first = task.parameters.at("references");
    const auto& chosen = task.parameters.at("options");
    Hasher name;
    name.add(chosen.dump());
    std::map<std::string, std::size_t> places;
    for (std::size_t i = first; i < task.inputs.size(); ++i) {
      places[task.inputs[i].substr(level_of(task.inputs[i]).size())] = i;
      name.add(reader.input_content(i).hex());
    }
    return reader.memo().get<Played>("played " + name.digest().hex(), [&] {
      const auto result = [&](const std::string& id) -> std::shared_ptr<const Artifact> {
        const auto place = places.find(id);
        return place == places.end() ? nullptr : reader.input(place->second);
      };
      // Those of a level of effort, where there are levels, and not those configured.
      OptionValues level = options;
      for (const auto& [key, value] : chosen.items()) level.set(key, value);
      return std::make_shared<Played>(method.assemble(result, level));
    });
  }
};

}  // namespace

std::shared_ptr<const BakeErrorMeter> make_bake_evaluator() {
  return std::make_shared<BakeEvaluator>();
}

}  // namespace prt
