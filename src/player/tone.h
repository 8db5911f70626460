// From radiance to the screen. Internal to player/.
#pragma once

#include <span>
#include <vector>

#include "base/types.h"

namespace prt {

/// Exposure that puts the 90th percentile of the luminance of what is lit at 0.6; 1 if nothing is.
float own_exposure(std::span<const Vec3f> radiance);

/// Narkowicz (2015), "ACES Filmic Tone Mapping Curve": display value in [0, 1], linear.
Vec3f filmic(const Vec3f& exposed);

/// Linear [0, 1] to 8-bit sRGB.
std::uint8_t srgb_byte(float linear);

}  // namespace prt
