#include "methods/sh/work.h"

#include "bases/spherical_harmonics.h"
#include "methods/common/work.h"
#include "methods/sh/plan.h"

namespace prt::sh {

std::vector<StageWork> stage_work(const BakeSize& size, const OptionValues& options,
                                  const StageFigures& figures) {
  const double n = size.samples;
  const double functions = sh_count(options.get<int>("sh.order"));
  const double rays = n * options.get<double>("rays.directions");
  const double per_cluster = n / size.clusters;
  const Transfer transfer = transfer_of(options);
  std::vector<StageWork> work = sampling_and_rays_work(size, options);
  if (transfer == Transfer::kUnshadowed)
    std::erase_if(work, [](const StageWork& stage) { return stage.stage == "rays"; });
  work.push_back({kDirect, size.clusters, 0, rays * functions, 4.0 * n * functions,
                  12.0 * rays / size.clusters});
  if (transfer == Transfer::kInterreflected) {
    const double rounds = figure(figures, kBounce, "rounds", 4.0);
    const double columns = figure(figures, kBounce, "channels", 3.0) * functions;
    work.push_back({kBounce, rounds * size.clusters, 0, rounds * rays * columns,
                    4.0 * rounds * n * columns, 12.0 * n * columns});
  }
  work.push_back({kTransfer, size.clusters, 0, n * functions * functions, 4.0 * n * functions,
                  16.0 * per_cluster * 4.0 * functions});
  return work;
}

}  // namespace prt::sh
