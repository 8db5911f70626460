// A z-buffer rasteriser: which triangle, and where on it, each pixel sees.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace prt {

/// What the pixel's centre sees: a triangle and the barycentric weights of its vertices 1 and 2.
struct Fragment {
  std::uint32_t triangle = kNone;
  float u = 0.0F;
  float v = 0.0F;
};

struct FragmentImage {
  int width = 0;
  int height = 0;
  std::vector<Fragment> fragments;  ///< height × width, top row first
};

/// Draws all triangles from both sides, nearest first, perspective-correct. Triangles are clipped
/// at the eye; a pixel centre on an edge that two triangles share belongs to exactly one of them
/// (top-left rule on 1/256 pixel), so meshes have no cracks. Alpha masks are honoured (opaque_at).
/// The same picture on any number of threads. Throws UserError for a size that is not positive or
/// beyond 16384.
FragmentImage rasterise(const Scene& scene, const SceneCamera& camera, int width, int height,
                        unsigned threads = 0);

/// Unit direction from the camera's eye through a point of the image, in pixels from the top left.
Vec3f view_direction(const SceneCamera& camera, int width, int height, float x, float y);

}  // namespace prt
