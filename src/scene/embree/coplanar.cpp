#include "scene/embree/coplanar.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <compare>

namespace prt {
namespace {

/// Planes count as equal within these steps; of the normal, and of the offset relative to the
/// scene.
constexpr double kNormalStep = 0x1p-14;
constexpr double kOffsetStep = 0x1p-20;
/// Overlaps narrower than this share of the two triangles are common edges.
constexpr double kEdge = 1e-6;
/// Comparisons per triangle of a plane, on average; beyond, all in the plane count as contested.
constexpr std::size_t kComparisons = 4096;

struct Plane {
  int axis;                           ///< largest component of the normal
  std::array<std::int64_t, 3> steps;  ///< the other two components, and the offset
  friend auto operator<=>(const Plane&, const Plane&) = default;
};

/// A triangle seen along the axis of its plane.
struct Outline {
  Plane plane;
  std::uint32_t triangle;
  std::array<Eigen::Vector2d, 3> corners;
  Eigen::Vector2d low;
  Eigen::Vector2d high;
};

Outline outline_of(const Scene& scene, std::uint32_t triangle) {
  std::array<Vec3d, 3> p;
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = scene.positions[scene.triangles[triangle].vertex[k]].cast<double>();
  }
  Vec3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  Outline outline;
  outline.triangle = triangle;
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  if (normal[axis] < 0.0) normal = -normal;
  const int first = (axis + 1) % 3;
  const int second = (axis + 2) % 3;
  const double offset = normal.dot(p[0]) / scene.diagonal();
  outline.plane = {
      axis,
      {std::llround(normal[first] / kNormalStep), std::llround(normal[second] / kNormalStep),
       std::llround(offset / kOffsetStep)}};
  for (std::size_t k = 0; k < 3; ++k) outline.corners[k] = {p[k][first], p[k][second]};
  outline.low = outline.corners[0].cwiseMin(outline.corners[1]).cwiseMin(outline.corners[2]);
  outline.high = outline.corners[0].cwiseMax(outline.corners[1]).cwiseMax(outline.corners[2]);
  return outline;
}

/// True if a line along an edge of `a` separates the two (separating axis theorem).
bool separated_by_edge(const Outline& a, const Outline& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2d edge = a.corners[(k + 1) % 3] - a.corners[k];
    const Eigen::Vector2d across(-edge.y(), edge.x());
    const auto extent = [&](const Outline& o) {
      return std::minmax(
          {across.dot(o.corners[0]), across.dot(o.corners[1]), across.dot(o.corners[2])});
    };
    const auto [low_a, high_a] = extent(a);
    const auto [low_b, high_b] = extent(b);
    const double edge_width = kEdge * std::min(high_a - low_a, high_b - low_b);
    if (high_a <= low_b + edge_width || high_b <= low_a + edge_width) return true;
  }
  return false;
}

/// Marks the overlapping ones among the outlines [begin, end) of one plane, sorted by low.x.
void mark_plane(const std::vector<Outline>& outlines, std::size_t begin, std::size_t end,
                std::vector<std::uint8_t>& contested) {
  std::size_t comparisons = kComparisons * (end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    const Outline& a = outlines[i];
    for (std::size_t j = i + 1; j < end && outlines[j].low.x() < a.high.x(); ++j) {
      const Outline& b = outlines[j];
      if (comparisons-- == 0) {
        for (std::size_t k = begin; k < end; ++k) contested[outlines[k].triangle] = 1;
        return;
      }
      if (b.low.y() >= a.high.y() || a.low.y() >= b.high.y()) continue;
      if (separated_by_edge(a, b) || separated_by_edge(b, a)) continue;
      contested[a.triangle] = contested[b.triangle] = 1;
    }
  }
}

}  // namespace

std::vector<std::uint8_t> contested_triangles(const Scene& scene) {
  std::vector<Outline> outlines;
  outlines.reserve(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    outlines.push_back(outline_of(scene, t));
  }
  std::sort(outlines.begin(), outlines.end(), [](const Outline& a, const Outline& b) {
    if (a.plane != b.plane) return a.plane < b.plane;
    return std::pair(a.low.x(), a.triangle) < std::pair(b.low.x(), b.triangle);
  });
  std::vector<std::uint8_t> contested(scene.triangles.size(), 0);
  for (std::size_t begin = 0; begin < outlines.size();) {
    std::size_t end = begin + 1;
    while (end < outlines.size() && outlines[end].plane == outlines[begin].plane) ++end;
    mark_plane(outlines, begin, end, contested);
    begin = end;
  }
  if (std::find(contested.begin(), contested.end(), 1) == contested.end()) contested.clear();
  return contested;
}

}  // namespace prt
