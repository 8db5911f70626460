// Surface points that light can reach: particles traced from a start point through random
// reflections (Leonhardt & Bohn, §4.1).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scene/ray_caster.h"

namespace prt {

/// Points of the reachable surface on the side that was hit.
struct SurfacePoints {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;  ///< geometric
  std::vector<std::uint32_t> triangles;
  [[nodiscard]] std::size_t size() const { return positions.size(); }
  void append(const SurfacePoints& other);
};

struct ParticleSettings {
  Vec3f start = Vec3f::Zero();
  int warm_up_reflections = 5;       ///< collisions up to this one are not kept (§4.1)
  int kept_reflections = 12;         ///< a particle ends after this many kept collisions
  std::size_t wanted = 0;            ///< stop once this many points are kept ...
  std::size_t ray_budget = 0;        ///< ... or about this many rays are used
  std::uint64_t stream = 0;          ///< random stream
  std::uint64_t first_particle = 0;  ///< number of the first particle: tasks use disjoint ranges
};

/// Traces particles in numbered order. Where nearly all escape before the warm-up is over (open
/// scenes), the second half of the ray budget keeps collisions from the first on.
SurfacePoints trace_particles(const Scene& scene, const RayCaster& caster,
                              const ParticleSettings& settings);

/// A start point for particles: among random points of the bounding box, and of places in front of
/// surfaces where those see no front faces to speak of, the one that sees most front faces, fewest
/// back faces and far: inside rooms, outside solids. Throws UserError if nothing is seen from
/// anywhere.
Vec3f find_start(const Scene& scene, const RayCaster& caster, std::uint64_t stream);

}  // namespace prt
