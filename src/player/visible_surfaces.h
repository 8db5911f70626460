// The surface points that a picture sees.
#pragma once

#include <cstdint>
#include <vector>

#include "player/evaluator.h"
#include "player/rasteriser.h"

namespace prt {

/// In picture order, without the pixels that see none.
struct VisibleSurfaces {
  std::vector<std::uint32_t> place;  ///< in the picture
  std::vector<PlayPoint> points;
  std::vector<Vec3f> albedo;
};

VisibleSurfaces visible_surfaces(const Scene& scene, const Vec3f& eye, const FragmentImage& image,
                                 unsigned threads);

}  // namespace prt
