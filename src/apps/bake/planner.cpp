#include "apps/bake/planner.h"

#include <algorithm>

#include "apps/bake/history.h"
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
                 const Scene& scene, const ArtifactStore& store, TimedLevels* timed)
    : program_(program),
      method_(method),
      options_(options),
      scene_(scene),
      timed_(timed),
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
  const bool by_levels = goal.wanted() || time_limit_of(options_);
  return by_levels ? plan_levels(goal, find) : plan_with(options_, "", find);
}

/// Of a finished bake; null where it is not measured.
nlohmann::json Planner::error_of(const BakePlan& plan, const FindResult& find) {
  if (!program_.evaluator || plan.evaluation_results.empty()) return nullptr;
  const auto judged = read(plan.evaluation_results.front(), find);
  return judged ? program_.evaluator->error(*judged, scene_.origin) : nlohmann::json();
}

nlohmann::json Planner::figures(const std::string& task, const FindResult& find) {
  const auto where = find(task);
  if (!where) return nlohmann::json::object();
  try {
    return figures_of(*cache_.get(*where));
  } catch (const UnsoundData&) {  // let go, or spoiled: a prediction can do without
    return nlohmann::json::object();
  }
}

BakePlan Planner::plan_level(int level, const FindResult& find) {
  return plan_with(options_at(method_, options_, level), std::to_string(level) + kLevelEnd, find);
}

/// Level after level until the goal is met or no other is likely to end in time, each begun once
/// the one before is done. A level's tasks have ids of their own; what two levels have in common is
/// made once.
BakePlan Planner::plan_levels(const AccuracyGoal& goal, const FindResult& find) {
  if (method_.effort_levels() == 0 || (goal.wanted() && !program_.evaluator)) {
    throw UserError((goal.wanted() ? "accuracy: the method " : "time_limit: the method ") +
                    method_.name() + " cannot aim at one; leave it out");
  }
  const auto limit = time_limit_of(options_);
  std::vector<TaskSpec> before;
  nlohmann::json levels = nlohmann::json::array();
  std::vector<LevelChoice> choices;
  for (int level = 0;;) {
    BakePlan plan = plan_level(level, find);
    plan.all.tasks.insert(plan.all.tasks.begin(), before.begin(), before.end());
    const auto is_done = [&](const TaskSpec& task) { return find(task.id).has_value(); };
    plan.all.complete = plan.all.complete && std::ranges::all_of(plan.all.tasks, is_done);
    if (!plan.all.complete) return plan;
    const nlohmann::json error = error_of(plan, find);
    levels.push_back(describe_level(level, plan.options, error));
    const double excess = goal.wanted() ? goal.excess(error) : 0.0;
    const bool met = goal.wanted() && excess <= 1.0;
    int next = met             ? level
               : goal.wanted() ? next_level(method_, level, excess)
                               : method_.effort_levels() - 1;
    if (limit && next != level) {
      plan.undecided = timed_ == nullptr;
      plan.all.complete = !plan.undecided;
      if (plan.undecided) return plan;
      const auto read_figures = [&](const std::string& task) { return figures(task, find); };
      choices.push_back(timed_->choose({level, plan.options, plan.prefix, read_figures}, next));
      next = choices.back().level;
    }
    if (next == level) {
      if (goal.wanted()) {
        plan.accuracy = {{"goal", describe_goal(goal)}, {"levels", levels}, {"met", met}};
      }
      if (limit) plan.time_limit = describe_time_limit(*limit, levels, choices);
      return plan;
    }
    before = std::move(plan.all.tasks);
    level = next;
  }
}

}  // namespace prt
