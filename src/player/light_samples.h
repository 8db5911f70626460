// Points of area lights at which players sample them (Leonhardt & Bohn, figure 5: 25 points).
#pragma once

#include <span>
#include <vector>

#include "scene/light.h"

namespace prt {

/// Coordinates (u, v) in [0, 1)² for incident_light: `count` cell centres of a stratification (m ×
/// m for square numbers, else a Hammersley set); one point for lights that are points themselves.
std::vector<Vec2f> light_samples(const Light& light, int count);
/// The same into `samples`.
void light_samples(const Light& light, int count, std::vector<Vec2f>& samples);

/// Irradiance at p on a surface of unit normal n, unshadowed, W/m²: mean over the light's samples.
Vec3f unshadowed_irradiance(const Light& light, std::span<const Vec2f> samples, const Vec3f& p,
                            const Vec3f& n);

}  // namespace prt
