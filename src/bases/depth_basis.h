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

}  // namespace prt
