#include "methods/lb/lb.h"

#include "methods/common/task_table.h"
#include "methods/lb/assemble.h"
#include "methods/lb/effort.h"
#include "methods/lb/plan.h"
#include "methods/lb/scene_part.h"
#include "methods/lb/tasks.h"
#include "methods/lb/work.h"

namespace prt {

namespace {

class LeonhardtBohn : public TableMethod {
 public:
  [[nodiscard]] std::string name() const override { return "lb"; }

  [[nodiscard]] std::vector<OptionSpec> options() const override {
    using Type = OptionSpec::Type;
    return {
        {"lb.visibility_rank",
         Type::kInteger,
         64,
         1,
         1000,
         {},
         "1",
         "most basis functions per cluster for depth buffers (d1)",
         "LB §4.2"},
        {"lb.distance_bias",
         Type::kNumber,
         0.07,
         0.0,
         0.9,
         {},
         "1",
         "share of its distance by which a light counts as nearer than it is",
         "LB §5"},
        {"lb.example_lights",
         Type::kInteger,
         1000,
         1,
         1000000,
         {},
         "1",
         "point lights from which the direct-light basis is made (l)",
         "LB §4.3.1"},
        {"lb.light_rank",
         Type::kInteger,
         20,
         1,
         1000,
         {},
         "1",
         "basis functions per cluster for direct light, in the mean (d2)",
         "LB §4.3.1"},
        {"lb.near_share",
         Type::kNumber,
         0.003,
         0.0001,
         1.0,
         {},
         "1",
         "senders that fill more of a sample's hemisphere, and more than 6 / rays.directions of "
         "it, "
         "send to it one by one; 1: none does",
         "beyond LB"},
        {"lb.region_clusters",
         Type::kIntegerOrAuto,
         "auto",
         1,
         1000000,
         {},
         "1",
         "most clusters whose light is solved for together, within a window of the clusters that "
         "they exchange light with; auto: all up to 256, else 64 (photons: all)",
         "beyond LB"},
        {"lb.window_tolerance",
         Type::kNumber,
         0.01,
         0.0,
         1.0,
         {},
         "1",
         "share of a region's indirect light that may stay outside its window, where the scene is "
         "lit uniformly; more may where windows are full at 192 clusters or three regions",
         "beyond LB"},
        {"lb.solver",
         Type::kText,
         "gather",
         0,
         0,
         {"gather", "photons"},
         "",
         "how transfer is computed: stored rays, or photon mapping as in the paper",
         "LB §4.3.2"},
        {"lb.photons",
         Type::kInteger,
         2000000,
         1,
         1e12,
         {},
         "1",
         "photons shot in all, shared out evenly among sender clusters",
         "LB §4.3.2"},
    };
  }

  [[nodiscard]] Plan plan(const PlanInputs& inputs) const override { return lb::make_plan(inputs); }

  [[nodiscard]] int effort_levels() const override { return lb::effort_levels(); }
  [[nodiscard]] OptionValues with_effort(const OptionValues& options, int level) const override {
    return lb::with_effort(options, level);
  }

  [[nodiscard]] std::vector<StageWork> work(const BakeSize& size, const OptionValues& options,
                                            const StageFigures& figures) const override {
    return lb::stage_work(size, options, figures);
  }

  [[nodiscard]] Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
      const OptionValues& options) const override {
    return lb::assemble_package(result, options);
  }

 protected:
  /// Sources are of Leonhardt & Bohn where no other paper is named.
  [[nodiscard]] const TaskTable& tasks() const override {
    static const TaskTable table = [] {
      TaskTable t = sampling_and_rays_tasks();
      t["visibility"] = {lb::run_visibility, "LB §4.2, eq. 8-9"};
      t["reach"] = {lb::run_reach, "one bounce of LB §4.3.2 between clusters"};
      t["windows"] = {lb::run_windows, "LB §4.3.2, eq. 4, between clusters"};
      t["lights"] = {lb::run_lights, "LB §4.3.1"};
      t["light_basis"] = {lb::run_light_basis, "LB §4.3.1 (uncentred)"};
      t["light_functions"] = {lb::run_light_functions, "LB §4.3.1"};
      t["window_functions"] = {lb::run_window_functions, "LB §4.3.1"};
      t["snapshot"] = {lb::run_snapshot,
                       "one bounce of LB §4.3.2, reduced by its singular vectors"};
      t["snapshot_functions"] = {lb::run_snapshot_functions, "LB §4.3.2"};
      t["galerkin"] = {lb::run_galerkin, "LB §4.3.2, eq. 4, by Galerkin projection"};
      t["solve"] = {lb::run_solve, "LB §4.3.2, eq. 4, by Galerkin projection"};
      t["near"] = {lb::run_near, "one bounce of LB §4.3.2, near senders one by one"};
      t["transfer"] = {lb::run_transfer, "LB §4.3.2, eq. 10, and §4.4"};
      t["residual"] = {lb::run_residual, "LB §4.3.2"};
      t["photons"] = {lb::run_photons, "LB §4.3.2"};
      t["photon_transfer"] = {lb::run_photon_transfer, "LB §4.3.2, eq. 10, and §4.4"};
      return t;
    }();
    return table;
  }
};

}  // namespace

const Method& lb_method() {
  static const LeonhardtBohn method;
  return method;
}

}  // namespace prt
