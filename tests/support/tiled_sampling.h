// The sampling stages alone, thinned in tiles though the scene is small.
#pragma once

#include "methods/common/sampling.h"
#include "methods/method.h"

namespace prt::test {

class TiledSampling : public Method {
 public:
  explicit TiledSampling(const ThinningSplit& split) : split_(split) {}
  [[nodiscard]] std::string name() const override { return "sampling"; }
  [[nodiscard]] std::vector<OptionSpec> options() const override { return {}; }
  [[nodiscard]] Plan plan(const PlanInputs& inputs) const override {
    Plan plan;
    plan.complete = plan_sampling(inputs, plan, split_);
    return plan;
  }
  [[nodiscard]] std::vector<std::string> kinds() const override { return sampling_kinds(); }
  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader) const override {
    return run_sampling(task, reader);
  }
  [[nodiscard]] std::string equation(const std::string&) const override { return ""; }
  [[nodiscard]] Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>&,
      const OptionValues&) const override {
    return {};
  }

 private:
  ThinningSplit split_;
};

}  // namespace prt::test
