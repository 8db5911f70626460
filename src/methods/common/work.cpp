#include "methods/common/work.h"

#include "methods/common/sampling.h"

namespace prt {

double figure(const StageFigures& figures, const std::string& stage, const std::string& name,
              double fallback) {
  const auto s = figures.find(stage);
  if (s == figures.end()) return fallback;
  const auto f = s->second.find(name);
  return f == s->second.end() ? fallback : f->second;
}

std::vector<StageWork> sampling_and_rays_work(const BakeSize& size, const OptionValues& options) {
  const double n = size.samples;
  const double directions = options.get<double>("rays.directions");
  const double rays = n * directions;
  const SamplingTasks tasks = sampling_tasks(n);
  // A position, a normal and a triangle: 28 bytes; a point of a cell is three words; a ray is six
  // bytes.
  const double candidates = 28.0 * tasks.candidates;
  const double points = 12.0 * tasks.cell_points;
  std::vector<StageWork> work = {
      {"start", 1, 0, 1, 3500, 0},
      {"candidates", tasks.candidate_tasks, 0, n, candidates, candidates / tasks.candidate_tasks},
      {"points", 1, 0, n, 46.0 * n, tasks.tiles > 1.0 ? candidates : 3.0 * candidates},
      {"cells", tasks.cell_tasks, 0, n, points, points / tasks.cell_tasks},
      {"samples", 1, 0, n, 50.0 * n, points},
      {"albedo", 1, 0, n, 12.0 * n, points},
      {"rays", size.clusters, rays, rays, 6.0 * rays, 12.0 * rays / size.clusters}};
  if (tasks.tiles > 1.0) {
    // With their numbers 32 bytes; halos, and what tiles leave, are small beside them.
    const double tiled = 32.0 * tasks.candidates;
    work.push_back({"tiles", tasks.sorting_tasks, 0, n, tiled, 2.0 * tiled / tasks.sorting_tasks});
    work.push_back({"highest", tasks.tiles, 0, n, tiled / 16.0, tiled / tasks.tiles});
    work.push_back({"spacing", 1, 0, n, 0, tiled / 8.0});
    work.push_back({"thin", tasks.tiles, 0, n, tiled / 4.0, 3.0 * tiled / tasks.tiles});
  }
  return work;
}

}  // namespace prt
