// Thinning of candidate points to a Poisson-disk set, and clusters of samples around root points
// (Leonhardt & Bohn, §4.1).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/types.h"
#include "scene/scene.h"

namespace prt {

/// Candidates for samples; parallel arrays.
struct Candidates {
  std::span<const Vec3f> positions;
  std::span<const Vec3f> normals;
  std::span<const float> curvatures;  ///< 1/m, see candidate_radius
  std::span<const std::uint64_t> priorities;
  [[nodiscard]] std::size_t size() const { return positions.size(); }
};

/// Curvature of a triangle, 1/m: the fastest turn of the shading normal along an edge. One function
/// for all stages, so that it is rounded alike in them.
float triangle_curvature(const Scene& scene, std::uint32_t triangle);

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

// ---- piece by piece: thin_to_count() of candidates that nobody holds at once --------------------
// Candidates are given in the order of their indices among all, so that equal priorities are told
// apart alike everywhere.

/// Radii, m.
struct RadiusRange {
  float low;
  float high;
  [[nodiscard]] bool contains(float radius) const { return low <= radius && radius <= high; }
};

/// Where thin_to_count() will look for the radius of so many candidates: the radius that it tries
/// first, and a range in which it is expected to stay. `highest`: the sixteenth of them that has
/// the highest priority, or more; `extent`: the diagonal of the box that holds all, m.
struct RadiusGuess {
  float first;
  RadiusRange range;
};
RadiusGuess guess_radius(const Candidates& highest, std::size_t candidates, float extent,
                         std::size_t count, float min_cosine);

/// Without those that give way whatever the radius of the range: thinning what is left keeps the
/// same at every radius of it. Ascending indices. `known`: all within so many metres of a candidate
/// are among these; a candidate that might give way to another one beyond is left.
std::vector<std::uint32_t> drop_beaten(const Candidates& candidates, std::span<const float> known,
                                       const RadiusRange& range, float min_cosine);

/// thin_to_count() of all candidates from those that drop_beaten() left; nothing if it tries a
/// radius out of the range.
std::optional<ThinnedTo> thin_to_count(const Candidates& left, const RadiusGuess& guess,
                                       std::size_t count, float min_cosine);

}  // namespace prt
