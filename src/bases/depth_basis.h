// Visibility as compressed depth buffers (Leonhardt & Bohn, §4.2).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/types.h"
#include "domains/directions.h"

namespace prt {

/// Depths are kept as z = √(t / bound) in [0, 1]; a ray that escapes has z = 1. `bound` (m) is at
/// least the longest distance in the scene.
inline float encode_depth(float t, float bound) {
  return t >= bound ? 1.0F : std::sqrt(std::max(t, 0.0F) / bound);
}
inline constexpr std::uint16_t kEscapedDepth = 65535;
/// 16-bit storage of an encoded depth: [0, 65534] for hits, 65535 for escape.
std::uint16_t pack_depth(float t, float bound, bool escaped);
inline float unpack_depth(std::uint16_t packed) {
  return packed == kEscapedDepth ? 1.0F : static_cast<float>(packed) / 65534.0F;
}

/// Share of light that passes, in [0, 1]: the bilinear weights of those of the four nearest
/// directions whose depth is not before the light (§5; soft test). `depth(i)` gives the encoded
/// depth of direction i. `local` is the unit direction to the light in the sample's frame;
/// `distance` in m, kInfinity for a light outside the scene. `bias` b: the light counts as in front
/// when distance·(1−b) <= depth.
template <typename Depth>
float depth_visibility(const HemisphereDirections& directions, const Depth& depth,
                       const Vec3f& local, float distance, float bound, float bias) {
  if (local.z() <= 0.0F) return 0.0F;
  const float threshold = std::sqrt(std::min(distance, bound) * (1.0F - bias) / bound);
  const auto four = directions.lookup(local);
  float share = 0.0F;
  for (int k = 0; k < 4; ++k) {
    if (depth(four.index[k]) >= threshold) share += four.weight[k];
  }
  return share;
}

/// Walls around a convex space with nothing in it: w × 4, each row the outward unit normal and the
/// offset (m) of a plane. A point p of the space has normal·p <= offset. No rows: nothing around.
inline constexpr Eigen::Index kMostWalls = 32;
/// Walls may be so far off, as a share of the depth bound: lights on them are still inside.
inline constexpr float kWallSlack = 1e-4F;

/// 1 where a light at `distance` (m, kInfinity for one outside the scene) in unit direction
/// `to_light` from a point inside stands within all walls, else 0. It replaces depth_visibility
/// where nothing but walls is in the way.
float wall_visibility(const MatrixF& walls, const Vec3f& inside, const Vec3f& to_light,
                      float distance, float bound);

}  // namespace prt
