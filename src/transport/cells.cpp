#include "transport/cells.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"

namespace prt {

namespace {

constexpr int kReachRays = 16;
constexpr float kLift = 0.25F;  // of the sample's radius

bool sees_sample(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                 std::uint32_t s, const Vec3f& position, const Vec3f& normal) {
  const Vec3f from = offset_origin(scene, position, normal);
  const Vec3f to = offset_origin(scene, samples.positions[s], samples.normals[s]);
  if (caster.visible(from, to)) return true;
  // Over the hill: a convex surface between the two does not hide them from each other. Straight up
  // must be free as well, or the way would lead through a thin board.
  const float lift = kLift * samples.radii[s];
  const Vec3f above = from + lift * normal;
  const Vec3f above_sample = to + lift * samples.normals[s];
  return caster.visible(from, above) && caster.visible(to, above_sample) &&
         caster.visible(above, above_sample);
}

/// Rays from a point whose nearest sample is hidden from it: reachable if one ends at a cell,
/// within sight of its sample.
bool reachable(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
               const SenderSearch& search, const Vec3f& position, const Vec3f& normal,
               Random& random) {
  std::array<Ray, kReachRays> rays;
  std::array<Hit, kReachRays> hits;
  const Vec3f origin = offset_origin(scene, position, normal);
  for (Ray& ray : rays) {
    const float u = random.uniform();
    ray = {origin, cosine_direction(normal, u, random.uniform())};
  }
  caster.intersect_coherent(rays, hits);
  for (int i = 0; i < kReachRays; ++i) {
    if (hits[i].escaped()) continue;
    const SurfacePoint end = surface_at(scene, rays[i], hits[i]);
    const std::uint32_t s = search.find_near(end);
    // Inside a thin board the far face's outer samples are near and compatible, but hidden.
    if (s != kNone && sees_sample(scene, caster, samples, s, end.position, end.normal)) return true;
  }
  return false;
}

}  // namespace

CellPoints draw_cell_points(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                            const SenderSearch& search, const std::vector<double>& cumulative,
                            std::uint64_t total, std::uint64_t first, std::uint64_t count,
                            std::uint64_t stream) {
  CellPoints points;
  for (std::uint64_t k = first; k < std::min(first + count, total); ++k) {
    Random random(stream, k);
    const auto [triangle, u, v] = area_point(cumulative, k, total, stream, random);
    if (!opaque_at(scene, triangle, u, v)) continue;
    const Vec3f position = triangle_point(scene, triangle, u, v);
    const Vec3f front = triangle_normal(scene, triangle);
    const std::array<Vec3f, 2> sides{front, -front};
    for (const Vec3f& normal : sides) {
      const bool is_front = &normal == &sides[0];
      const std::uint32_t s = search.find_near({position, normal, triangle, u, v, is_front});
      if (s == kNone) continue;
      if (!sees_sample(scene, caster, samples, s, position, normal) &&
          !reachable(scene, caster, samples, search, position, normal, random)) {
        continue;
      }
      points.samples.push_back(s);
      points.triangles.push_back(triangle);
      points.barycentric.push_back(u);
      points.barycentric.push_back(v);
    }
  }
  return points;
}

}  // namespace prt
