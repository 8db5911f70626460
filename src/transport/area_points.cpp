#include "transport/area_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "transport/free_space.h"

namespace prt {

std::vector<double> cumulative_areas(const Scene& scene) {
  std::vector<double> sums(scene.triangles.size() + 1, 0.0);
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    sums[t + 1] = sums[t] + triangle_area(scene, t);
  }
  return sums;
}

AreaPoint area_point(const std::vector<double>& cumulative, std::uint64_t k, std::uint64_t total,
                     std::uint64_t stream, Random& random) {
  const double along = (static_cast<double>(k) + random.uniform()) / static_cast<double>(total);
  const auto above =
      std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, along * cumulative.back());
  const auto triangle = static_cast<std::uint32_t>(above - cumulative.begin() - 1);
  // One shift per triangle: without it, points of triangles that follow each other in a regular
  // mesh would repeat a pattern.
  Random shift(stream_key(stream, "shift of a triangle"), triangle);
  const auto turn = [&](double step) {
    const double x = step * static_cast<double>(k) + shift.uniform();
    return static_cast<float>(x - std::floor(x));
  };
  const float u = turn(0.7548776662466927);
  const float v = turn(0.5698402909980532);
  if (u + v <= 1.0F) return {triangle, u, v};
  return {triangle, 1.0F - u, 1.0F - v};
}

namespace {

// Places where a light might stand, and the points of the box tried for them.
constexpr std::uint64_t kPlaces = 512;
constexpr std::uint64_t kTries = 2048;
// Of the points before one (half of all, mostly) so many are looked at. For places many, or none
// would be found behind the hills, where particles seldom come; for points fewer: one that sees a
// tenth of the places is missed one time in five, which costs a candidate and no more.
constexpr int kLooksOfPlace = 128;
constexpr int kLooksOfPoint = 16;
// Points drawn for each that is looked at.
constexpr int kDraws = 4;
// A ray may pass an edge that one of its ends lies on, some 1 in 100,000. Places therefore must see
// two of the points that particles met, and the points drawn here keep off the edges of their
// triangles, by this share of their size.
constexpr int kWitnesses = 2;
constexpr float kEdge = 1e-4F;

/// True if `sees(i)` for so many of the points i < count drawn; it says nothing for points behind.
template <typename Sees>
bool sees_some(std::size_t count, int needed, int most_looks, Random& random, const Sees& sees) {
  int looks = 0;
  int seen = 0;
  for (int i = 0; i < kDraws * most_looks && looks < most_looks && count > 0; ++i) {
    const std::optional<bool> look = sees(random.below(static_cast<std::uint32_t>(count)));
    looks += look ? 1 : 0;
    seen += look.value_or(false) ? 1 : 0;
    if (seen == needed) return true;
  }
  return false;
}

std::vector<Vec3f> light_places(const Scene& scene, const RayCaster& caster,
                                const SurfacePoints& reached, const AreaPointSettings& settings) {
  const LightBox box = light_box(reached.positions);
  std::vector<Vec3f> places;
  for (std::uint64_t k = 0; k < kTries && places.size() < kPlaces; ++k) {
    Random random(settings.stream, settings.total + k);
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    const Vec3f place = box.low + (box.high - box.low).cwiseProduct(Vec3f(x, y, z));
    const auto sees = [&](std::uint32_t r) -> std::optional<bool> {
      const Vec3f from = offset_origin(scene, reached.positions[r], reached.normals[r]);
      if (!((place - from).dot(reached.normals[r]) > 0.0F)) return std::nullopt;
      return caster.visible(from, place);
    };
    const auto from_start = [&](const Vec3f& start) { return caster.visible(start, place); };
    if (std::ranges::any_of(settings.starts, from_start) ||
        sees_some(reached.size(), kWitnesses, kLooksOfPlace, random, sees)) {
      places.push_back(place);
    }
  }
  return places;
}

bool reachable(const Scene& scene, const RayCaster& caster, const std::vector<Vec3f>& places,
               const std::vector<Vec3f>& starts, const Vec3f& position, const Vec3f& normal,
               Random& random) {
  const Vec3f from = offset_origin(scene, position, normal);
  if (std::ranges::any_of(starts, [&](const Vec3f& start) {
        return (start - from).dot(normal) > 0.0F && caster.visible(from, start);
      })) {
    return true;
  }
  return sees_some(places.size(), 1, kLooksOfPoint, random,
                   [&](std::uint32_t i) -> std::optional<bool> {
                     if (!((places[i] - from).dot(normal) > 0.0F)) return std::nullopt;
                     return caster.visible(from, places[i]);
                   });
}

}  // namespace

SurfacePoints draw_area_points(const Scene& scene, const RayCaster& caster,
                               const SurfacePoints& reached, const AreaPointSettings& settings) {
  SurfacePoints kept;
  if (reached.size() == 0) return kept;
  const std::vector<Vec3f> places = light_places(scene, caster, reached, settings);
  const std::vector<double> cumulative = cumulative_areas(scene);
  for (std::uint64_t k = settings.first; k < settings.total; k += settings.step) {
    Random random(settings.stream, k);
    const AreaPoint p = area_point(cumulative, k, settings.total, settings.stream, random);
    if (std::min({p.u, p.v, 1.0F - p.u - p.v}) < kEdge) continue;
    if (!opaque_at(scene, p.triangle, p.u, p.v)) continue;
    const Vec3f position = triangle_point(scene, p.triangle, p.u, p.v);
    const Vec3f front = triangle_normal(scene, p.triangle);
    for (const Vec3f& normal : std::array<Vec3f, 2>{front, -front}) {
      if (!reachable(scene, caster, places, settings.starts, position, normal, random)) continue;
      kept.positions.push_back(position);
      kept.normals.push_back(normal);
      kept.triangles.push_back(p.triangle);
    }
  }
  return kept;
}

}  // namespace prt
