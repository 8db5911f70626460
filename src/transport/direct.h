// Direct light of example point lights at samples (Leonhardt & Bohn, §4.3.1).
#pragma once

#include <span>

#include "domains/samples.h"
#include "scene/ray_caster.h"

namespace prt {

/// Irradiance that point lights of intensity 1 W/sr cause at samples [begin, end), with ray-traced
/// shadows: lights × samples, W/m². 1/r² is clipped below `nearest` (m), since a few lights close
/// to a surface would own any basis made from the rows; 0: not clipped.
MatrixF direct_irradiance(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                          std::uint32_t begin, std::uint32_t end, std::span<const Vec3f> lights,
                          float nearest);

}  // namespace prt
