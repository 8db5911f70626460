#include "apps/prt_bake_evaluator.h"

#include <algorithm>
#include <map>

#include "evaluate/bake_evaluation.h"
#include "methods/common/sampling.h"
#include "store/manifest.h"

namespace prt {

namespace {

constexpr const char* kCompareKind = "compare";
constexpr const char* kEvaluateKind = "evaluate";

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
    Plan plan = plan_evaluation(options, kSamplesTask,
                                method_plan.complete ? &method_plan.results : nullptr);
    // The package that is judged depends on options, too, not on artifacts alone.
    for (TaskSpec& task : plan.tasks) {
      if (task.kind == kCompareKind) task.parameters["options"] = options_of_results(options);
    }
    return plan;
  }

  [[nodiscard]] std::vector<std::string> kinds() const override { return evaluation_kinds(); }

  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader, const Method& method,
                             const OptionValues& options) const override {
    if (task.kind == kCompareKind) {
      return run_compare(task, reader, played(task, reader, method, options)->player);
    }
    return task.kind == kEvaluateKind ? run_evaluate(task, reader) : run_reference(task, reader);
  }

  [[nodiscard]] std::vector<StageWork> work(const BakeSize& size,
                                            const OptionValues& options) const override {
    return evaluation_work(size, options);
  }

  [[nodiscard]] nlohmann::json error(const Artifact& result, const Vec3d& origin) const override {
    return summarise(result, origin);
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
