// Colours of pictures that no light gives, linear. Internal to player/.
#pragma once

#include <cmath>

#include "base/types.h"

namespace prt {

/// Where there is no surface: a calm dark blue that no lit surface has.
inline Vec3f background_colour() { return {0.010F, 0.013F, 0.020F}; }
/// Visibility where the light shines from behind.
inline Vec3f unlit_colour() { return {0.12F, 0.01F, 0.01F}; }

/// A colour for each cluster, far from its neighbours' by the golden ratio.
inline Vec3f cluster_colour(std::uint32_t cluster) {
  const float hue = std::fmod(0.618034F * static_cast<float>(cluster), 1.0F);
  Vec3f colour;
  for (int channel = 0; channel < 3; ++channel) {
    const float phase = hue + static_cast<float>(channel) / 3.0F;
    colour[channel] = 0.5F + 0.45F * std::cos(2.0F * kPi * phase);
  }
  return cluster % 2 == 0 ? colour : Vec3f(0.45F * colour);
}

}  // namespace prt
