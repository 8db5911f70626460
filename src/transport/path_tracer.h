// The reference: irradiance at given points by unbiased path tracing with next-event estimation
// (Veach 1997, §10). Lambert surfaces, nothing clamped; it shares surface_at, albedo_at and
// offset_origin with the estimators that it judges, and nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/environment.h"
#include "scene/light.h"
#include "scene/ray_caster.h"

namespace prt {

/// A point whose irradiance is asked for: position (m) and unit normal of the side that receives.
struct ReceiverPoint {
  Vec3f position;
  Vec3f normal;
};

struct PathTracerSettings {
  int paths = 64;  ///< per point, both halves together; rounded up to even, at least 2
  int bounces =
      -1;  ///< reflections at most; -1: no limit, ended by Russian roulette; 0: no indirect
  const Environment* environment = nullptr;  ///< shines beside the lights; null: none
};

/// Irradiance (W/m², RGB) from two independent halves of the paths: their means are the references
/// r1 and r2 of the unbiased error, their difference shows the noise.
struct IrradianceEstimate {
  std::array<Vec3f, 2> direct{Vec3f::Zero(), Vec3f::Zero()};
  std::array<Vec3f, 2> indirect{Vec3f::Zero(), Vec3f::Zero()};
  [[nodiscard]] Vec3f mean_direct() const { return 0.5F * (direct[0] + direct[1]); }
  [[nodiscard]] Vec3f mean_indirect() const { return 0.5F * (indirect[0] + indirect[1]); }
};

/// Traces all points under the sum of the lights and the environment. Direct light of punctual
/// lights is exact (one shadow ray, both halves equal). The first directions of each half are a
/// randomised (0,m,2)-net over the cosine-weighted hemisphere. Point i depends on (stream,
/// first_item + i) alone, so ranges may be traced by different tasks. Pure; call it from several
/// threads at will.
std::vector<IrradianceEstimate> trace_irradiance(const Scene& scene, const RayCaster& caster,
                                                 std::span<const Light> lights,
                                                 std::span<const ReceiverPoint> points,
                                                 const PathTracerSettings& settings,
                                                 std::uint64_t stream,
                                                 std::uint64_t first_item = 0);

}  // namespace prt
