#include "methods/sh/sh.h"

#include "bases/spherical_harmonics.h"
#include "methods/common/task_table.h"
#include "methods/sh/assemble.h"
#include "methods/sh/plan.h"
#include "methods/sh/tasks.h"
#include "methods/sh/work.h"

namespace prt {

namespace {

class SphericalHarmonics : public TableMethod {
 public:
  [[nodiscard]] std::string name() const override { return "sh"; }

  [[nodiscard]] std::vector<OptionSpec> options() const override {
    using Type = OptionSpec::Type;
    return {{"sh.order",
             Type::kInteger,
             5,
             1,
             kMostShOrder,
             {},
             "1",
             "bands of spherical harmonics; order n has n² functions",
             "SH §4"},
            {"sh.transfer",
             Type::kText,
             "interreflected",
             0,
             0,
             {"unshadowed", "shadowed", "interreflected"},
             "",
             "what surfaces do to the sky's light: nothing (and no ray is cast), block it, or "
             "block and reflect it, transport.bounces times",
             "SH §6.2.6"},
            {"sh.window",
             Type::kNumber,
             0.0,
             0.0,
             100.0,
             {},
             "bands",
             "width of the Hann window that takes ringing, and sharpness, from the sky; 0: none",
             "beyond SH"},
            {"evaluate.environments",
             Type::kInteger,
             2,
             0,
             1000,
             {},
             "",
             "test environments by which the bake measures its own error; 0: it does not",
             "ours"}};
  }

  [[nodiscard]] Plan plan(const PlanInputs& inputs) const override { return sh::make_plan(inputs); }

  [[nodiscard]] std::vector<StageWork> work(const BakeSize& size, const OptionValues& options,
                                            const StageFigures& figures) const override {
    return sh::stage_work(size, options, figures);
  }

  [[nodiscard]] Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
      const OptionValues& options) const override {
    return sh::assemble_package(result, options);
  }

 protected:
  [[nodiscard]] const TaskTable& tasks() const override {
    static const TaskTable table = [] {
      TaskTable t = sampling_and_rays_tasks();
      t[sh::kDirect] = {sh::run_direct, "SH §6.2.6.1-2"};
      t[sh::kBounce] = {sh::run_bounce, "SH §6.2.6.3"};
      t[sh::kTransfer] = {sh::run_transfer, "SH §6.2.6, as low rank"};
      return t;
    }();
    return table;
  }
};

}  // namespace

const Method& sh_method() {
  static const SphericalHarmonics method;
  return method;
}

}  // namespace prt
