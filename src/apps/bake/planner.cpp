#include "apps/bake/planner.h"

#include <algorithm>

#include "base/error.h"
#include "store/manifest.h"

namespace prt {

namespace {
/// Small: planners look at summaries.
constexpr std::size_t kCacheBytes = std::size_t{128} << 20;
}  // namespace

class Planner::Inputs : public PlanInputs {
 public:
  Inputs(Planner& planner, const OptionValues& options, std::string prefix, const FindResult& find)
      : planner_(planner), options_(options), prefix_(std::move(prefix)), find_(find) {}
  [[nodiscard]] const Scene& scene() const override { return planner_.scene_; }
  [[nodiscard]] const OptionValues& options() const override { return options_; }
  [[nodiscard]] std::shared_ptr<const Artifact> result(const std::string& task) const override {
    return planner_.read(prefix_ + task, find_);
  }

 private:
  Planner& planner_;
  const OptionValues& options_;
  std::string prefix_;
  const FindResult& find_;
};

Planner::Planner(const BakeProgram& program, const Method& method, const OptionValues& options,
                 const Scene& scene, const ArtifactStore& store)
    : program_(program),
      method_(method),
      options_(options),
      scene_(scene),
      cache_(store, kCacheBytes) {}

std::shared_ptr<const Artifact> Planner::read(const std::string& task, const FindResult& find) {
  const auto where = find(task);
  if (!where) return nullptr;
  read_.insert(task);
  try {
    return cache_.get(*where);
  } catch (const UnsoundData& e) {
    throw ResultDistrusted(task, e.what());
  }
}

namespace {

void put_before(const std::string& prefix, std::vector<std::string>& ids) {
  for (std::string& id : ids) id.insert(0, prefix);
}

}  // namespace

BakePlan Planner::plan_with(const OptionValues& options, const std::string& prefix,
                            const FindResult& find) {
  BakePlan plan;
  plan.options = options;
  plan.prefix = prefix;
  plan.all = method_.plan(Inputs(*this, options, prefix, find));
  if (program_.evaluator) {
    Plan extra = program_.evaluator->plan(options, plan.all);
    std::ranges::move(extra.tasks, std::back_inserter(plan.all.tasks));
    std::ranges::move(extra.left_out, std::back_inserter(plan.all.left_out));
    plan.all.complete = plan.all.complete && extra.complete;
    plan.evaluation_results = extra.results;
  }
  for (TaskSpec& task : plan.all.tasks) {
    task.id = prefix + task.id;
    put_before(prefix, task.inputs);
  }
  put_before(prefix, plan.all.results);
  put_before(prefix, plan.evaluation_results);
  return plan;
}

BakePlan Planner::plan(const FindResult& find) {
  const AccuracyGoal goal(options_);
  return goal.wanted() ? plan_for(goal, find) : plan_with(options_, "", find);
}

/// Level after level until the goal is met, each begun once the one before is judged. A level's
/// tasks have ids of their own; what two levels have in common is made once.
BakePlan Planner::plan_for(const AccuracyGoal& goal, const FindResult& find) {
  if (method_.effort_levels() == 0 || !program_.evaluator) {
    throw UserError("accuracy: the method " + method_.name() + " cannot aim at one; leave it out");
  }
  std::vector<TaskSpec> before;
  nlohmann::json levels = nlohmann::json::array();
  for (int level = 0;;) {
    BakePlan plan =
        plan_with(options_at(method_, options_, level), std::to_string(level) + kLevelEnd, find);
    plan.all.tasks.insert(plan.all.tasks.begin(), before.begin(), before.end());
    const auto judged = plan.all.complete ? read(plan.evaluation_results.front(), find) : nullptr;
    plan.all.complete = judged != nullptr;
    if (!judged) return plan;
    const nlohmann::json error = program_.evaluator->error(*judged, scene_.origin);
    levels.push_back(describe_level(level, plan.options, error));
    const double excess = goal.excess(error);
    const int next = next_level(method_, level, excess);
    if (excess <= 1.0 || next == level) {
      plan.accuracy = {
          {"goal", nlohmann::json::object()}, {"levels", levels}, {"met", excess <= 1.0}};
      if (goal.indirect) plan.accuracy["goal"]["indirect"] = *goal.indirect;
      if (goal.visibility) plan.accuracy["goal"]["visibility"] = *goal.visibility;
      return plan;
    }
    before = std::move(plan.all.tasks);
    level = next;
  }
}

}  // namespace prt
