#include "scaling/rank_set_up.h"

#include <optional>

#include "base/random.h"
#include "package/read.h"
#include "scaling/simulation.h"
#include "scene/embree/embree_ray_caster.h"
#include "transport/area_points.h"
#include "transport/sender_search.h"

namespace prt::scaling {

namespace {

// Points looked up per sample: hardly a list is missed.
constexpr std::uint64_t kLooks = 16;

/// The search makes its lists where it is asked. What looking itself takes is taken off again.
double search_everywhere(const Package& package) {
  const std::vector<double> cumulative = cumulative_areas(package.scene);
  const std::uint64_t total = kLooks * package.samples.size();
  std::vector<SurfacePoint> points;
  for (std::uint64_t k = 0; k < total; ++k) {
    Random random(0, k);
    const auto [t, u, v] = area_point(cumulative, k, total, 0, random);
    const Vec3f normal = triangle_normal(package.scene, t);
    points.push_back({triangle_point(package.scene, t, u, v), normal, t, u, v, true});
    points.push_back({points.back().position, -normal, t, u, v, false});
  }
  std::vector<std::uint32_t> found(points.size());
  std::optional<SenderSearch> search;
  const double making = timed([&] {
    search.emplace(package.scene, package.samples);
    search->find(points, found);
  });
  return making - timed([&] { search->find(points, found); });
}

}  // namespace

RankSetUp measure_set_up(const std::string& package_file) {
  const Package package = read_package(package_file);
  RankSetUp set_up;
  set_up.triangles = static_cast<double>(package.scene.triangles.size());
  set_up.area = cumulative_areas(package.scene).back();
  set_up.samples = static_cast<double>(package.samples.size());
  set_up.caster_seconds = timed([&] { (void)make_embree_ray_caster(package.scene); });
  set_up.search_seconds = search_everywhere(package);
  return set_up;
}

}  // namespace prt::scaling
