// Counter-based random numbers: a value is a pure function of (seed, stream, item, index), so
// results depend neither on the order of work nor on who does it (Salmon et al. 2011,
// Philox4x32-10).
#pragma once

#include <Random123/philox.h>

#include <cstdint>
#include <string_view>

#include "base/types.h"

namespace prt {

/// A named stream of a seed, e.g. stream_key(seed, "particles"). Different names are independent.
std::uint64_t stream_key(std::uint64_t seed, std::string_view name);

/// Draws the random numbers of one item of a stream, in order.
class Random {
 public:
  Random(std::uint64_t stream, std::uint64_t item)
      : key_{{static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(stream >> 32)}},
        item_(item) {}

  std::uint32_t bits() {
    if (used_ == 4) {
      const philox4x32_ctr_t counter{{static_cast<std::uint32_t>(item_),
                                      static_cast<std::uint32_t>(item_ >> 32), block_++, 0}};
      block_values_ = philox4x32(counter, key_);
      used_ = 0;
    }
    return block_values_.v[used_++];
  }

  /// Uniform in [0, 1).
  float uniform() { return static_cast<float>(bits() >> 8) * 0x1p-24F; }
  /// Uniform in [0, n), n > 0; bias below n / 2^32.
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(bits()) * n) >> 32);
  }

 private:
  philox4x32_key_t key_;
  std::uint64_t item_;
  std::uint32_t block_ = 0;
  philox4x32_ctr_t block_values_{};
  int used_ = 4;
};

/// Orthonormal frame with the given unit normal as third column (Duff et al. 2017). Continuous but
/// for normals near -z.
Mat3f frame_from_normal(const Vec3f& normal);

/// Direction with density cos(theta)/pi about the unit normal, from two uniforms in [0, 1).
Vec3f cosine_direction(const Vec3f& normal, float u, float v);

/// Direction with uniform density over the sphere.
Vec3f sphere_direction(float u, float v);

}  // namespace prt
