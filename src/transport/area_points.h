// Points uniform in area over the scene's surface, and those of them that light can reach.
#pragma once

#include <cstdint>
#include <vector>

#include "base/random.h"
#include "transport/particles.h"

namespace prt {

/// A point of the surface: weights of the triangle's vertices 1 and 2.
struct AreaPoint {
  std::uint32_t triangle;
  float u, v;
};

/// Running sums of triangle areas, to pick area-uniform points; triangles + 1 entries, m².
std::vector<double> cumulative_areas(const Scene& scene);

/// Point k of `total` points spread evenly over the whole surface: stratified over the triangles,
/// and on each of them a Kronecker sequence (Roberts' R2) that is shifted at random, by `stream`.
AreaPoint area_point(const std::vector<double>& cumulative, std::uint64_t k, std::uint64_t total,
                     std::uint64_t stream, Random& random);

struct AreaPointSettings {
  std::vector<Vec3f> starts;  ///< where particles start: in the open
  std::uint64_t total = 0;    ///< stratified points, each looked at from both sides
  std::uint64_t first = 0;    ///< those numbered first, first + step, ...: tasks take turns
  std::uint64_t step = 1;
  std::uint64_t stream = 0;  ///< random stream
};

/// The points that light can reach: those that see a start, or a place where a light might
/// stand: random ones of the light_box of `reached`, where particles were, that see a start or
/// two points of `reached` from their front. Fills in what particles seldom meet, far ground in an
/// open scene, and adds nothing inside solids or outside closed rooms. Depends on `reached` and the
/// settings alone; none where nothing was reached.
SurfacePoints draw_area_points(const Scene& scene, const RayCaster& caster,
                               const SurfacePoints& reached, const AreaPointSettings& settings);

}  // namespace prt
