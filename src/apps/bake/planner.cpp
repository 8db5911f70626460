#include "apps/bake/planner.h"

#include <algorithm>

namespace prt {

namespace {
/// Small: planners look at summaries.
constexpr std::size_t kCacheBytes = std::size_t{128} << 20;
}  // namespace

class Planner::Inputs : public PlanInputs {
 public:
  Inputs(Planner& planner, const FindResult& find) : planner_(planner), find_(find) {}
  [[nodiscard]] const Scene& scene() const override { return planner_.scene_; }
  [[nodiscard]] const OptionValues& options() const override { return planner_.options_; }
  [[nodiscard]] std::shared_ptr<const Artifact> result(const std::string& task) const override {
    return planner_.read(task, find_);
  }

 private:
  Planner& planner_;
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

BakePlan Planner::plan(const FindResult& find) {
  BakePlan plan;
  plan.all = method_.plan(Inputs(*this, find));
  if (!program_.evaluator) return plan;
  Plan extra = program_.evaluator->plan(options_, plan.all);
  std::ranges::move(extra.tasks, std::back_inserter(plan.all.tasks));
  std::ranges::move(extra.left_out, std::back_inserter(plan.all.left_out));
  plan.all.complete = plan.all.complete && extra.complete;
  plan.evaluation_results = extra.results;
  return plan;
}

}  // namespace prt
