// Ray casting behind an interface; the implementation over Embree is scene/embree/.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace prt {

/// Thread-safe for concurrent calls. Same rays, same scene and same build give the same hits.
class RayCaster {
 public:
  virtual ~RayCaster() = default;

  /// Nearest hit of one ray; ties go to the lowest triangle.
  [[nodiscard]] virtual Hit intersect(const Ray& ray) const = 0;
  /// Nearest hits of many rays, in packets of 16 with the coherent flag: for neighbouring
  /// directions from one origin. hits.size() == rays.size().
  virtual void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
  /// Nearest hits of unrelated rays.
  virtual void intersect_incoherent(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
  /// blocked[i] = 1 if anything lies in (t_near, t_far) of ray i.
  virtual void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const = 0;

  /// Distance from p to the nearest surface, m, or `limit` if none is nearer. Alpha-masked
  /// triangles count whole.
  [[nodiscard]] virtual float closest_distance(const Vec3f& p, float limit) const = 0;

  /// True if nothing lies between two points, each taken off its surface by the caller.
  [[nodiscard]] bool visible(const Vec3f& from, const Vec3f& to) const;
};

}  // namespace prt
