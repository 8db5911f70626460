// Lights as the user gives them, shared by the path tracer and the players.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/types.h"

namespace prt {

struct Light {
  enum class Kind { kPoint, kSphere, kSpot, kQuad, kSun } kind = Kind::kPoint;
  Vec3f position = Vec3f::Zero();     ///< centre, m (not kSun)
  Vec3f direction = -Vec3f::UnitY();  ///< unit, the way the light travels (kSpot, kSun)
  Vec3f intensity = Vec3f::Ones();    ///< kPoint, kSphere, kSpot: W/sr; kQuad: radiance W/(m² sr);
                                      ///< kSun: irradiance on a facing plane, W/m²
  float radius = 0.0F;                ///< kSphere, m; its radiance is intensity / (π radius²)
  float inner_angle = 0.0F;           ///< kSpot: full intensity inside, radians from the axis
  float outer_angle = 0.0F;  ///< kSpot: none outside; between them KHR_lights_punctual's falloff
  Vec3f edge_u =
      Vec3f::Zero();  ///< kQuad: full edges, m; the quad is position ± edge_u/2 ± edge_v/2
  Vec3f edge_v = Vec3f::Zero();  ///< kQuad emits towards edge_u × edge_v only

  bool operator==(const Light&) const = default;
};

/// One sample of the light that reaches p, unshadowed. Averaged over (u, v) uniform in [0,1)²,
/// irradiance · max(0, n·to_light) · visibility is the irradiance at p without bias. For kPoint,
/// kSpot and kSun it does not depend on (u, v).
struct IncidentLight {
  Vec3f to_light = Vec3f::UnitY();   ///< unit
  float distance = 0.0F;             ///< m; kInfinity for kSun
  Vec3f irradiance = Vec3f::Zero();  ///< on a plane facing the light, W/m²
};
IncidentLight incident_light(const Light& light, const Vec3f& p, float u, float v);

/// True if one sample is the whole answer (kPoint, kSpot, kSun).
bool is_punctual(const Light& light);

/// A light as a user types it: its place is in the world.
struct WorldLight {
  Light light;                                        ///< all but its position
  Vec3d position = Vec3d::Zero();                     ///< centre, m, world (not kSun)
  [[nodiscard]] Light in(const Vec3d& origin) const;  ///< in a scene of that origin
};

/// Parses a light SPEC of the command line, e.g. "point:0,2,0:10,10,10" (the forms are those of
/// --help). Throws UserError with the form expected.
WorldLight parse_light(std::string_view spec);

/// All of them in a scene of that origin.
std::vector<Light> lights_in(const Vec3d& origin, std::span<const WorldLight> lights);

}  // namespace prt
