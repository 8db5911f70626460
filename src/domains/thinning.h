// Thinning of candidate points to a Poisson-disk set, and clusters of samples around root points
// (Leonhardt & Bohn, §4.1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/types.h"

namespace prt {

/// Candidates for samples; parallel arrays.
struct Candidates {
  std::span<const Vec3f> positions;
  std::span<const Vec3f> normals;
  std::span<const float> curvatures;  ///< 1/m, see candidate_radius
  std::span<const std::uint64_t> priorities;
  [[nodiscard]] std::size_t size() const { return positions.size(); }
};

/// The Poisson-disk radius at a point: shrinks with curvature κ to radius / (1 + κ·radius), at
/// least a quarter.
float candidate_radius(float radius, float curvature);

/// A maximal subset of the candidates in which no two compatible ones (normals within 60°) are
/// nearer than the smaller of their radii. It is the set that accepts candidates by falling
/// priority, which is also the fixed point of "stay if of highest priority within the radius among
/// the undecided", so any partition of the work gives the same set. Ascending candidate indices.
std::vector<std::uint32_t> thin(const Candidates& candidates, float radius, float min_cosine);

/// The radius at which thin() keeps `count` candidates, to 1.5 %; and that set.
struct ThinnedTo {
  float radius;
  std::vector<std::uint32_t> kept;
};
ThinnedTo thin_to_count(const Candidates& candidates, std::size_t count, float min_cosine);

}  // namespace prt
