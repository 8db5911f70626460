#include "scaling/rank_set_up.h"

#include "package/read.h"
#include "scaling/simulation.h"
#include "scene/embree/embree_ray_caster.h"
#include "transport/area_points.h"
#include "transport/sender_search.h"

namespace prt::scaling {

RankSetUp measure_set_up(const std::string& package_file) {
  const Package package = read_package(package_file);
  RankSetUp set_up;
  set_up.triangles = static_cast<double>(package.scene.triangles.size());
  set_up.area = cumulative_areas(package.scene).back();
  set_up.samples = static_cast<double>(package.samples.size());
  set_up.caster_seconds = timed([&] { (void)make_embree_ray_caster(package.scene); });
  set_up.search_seconds = timed([&] { const SenderSearch search(package.scene, package.samples); });
  return set_up;
}

}  // namespace prt::scaling
