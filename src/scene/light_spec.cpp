// Light specifications of the command line.
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "scene/light.h"
#include "scene/scene.h"
#include "scene/spec_fields.h"

namespace prt {
namespace {

constexpr float kRadiansPerDegree = kPi / 180.0F;

constexpr std::array kKinds = {Light::Kind::kPoint, Light::Kind::kSphere, Light::Kind::kSpot,
                               Light::Kind::kQuad, Light::Kind::kSun};

/// One of each kind, in that order.
const std::vector<SpecForm>& forms() {
  static const std::vector<SpecForm> all = {
      {"point", "point:x,y,z:r,g,b", {3, 3}},
      {"sphere", "sphere:x,y,z:r,g,b:radius", {3, 3, 1}},
      {"spot", "spot:x,y,z:dx,dy,dz:r,g,b:inner_deg,outer_deg", {3, 3, 3, 2}},
      {"quad", "quad:cx,cy,cz:ux,uy,uz:vx,vy,vz:r,g,b", {3, 3, 3, 3}},
      {"sun", "sun:dx,dy,dz:r,g,b", {3, 3}},
  };
  return all;
}

void read_spot(const SpecFields& spec, Light& light) {
  light.direction = spec.unit_direction(1);
  light.intensity = spec.colour(2);
  const float inner = spec.number(3, 0);
  const float outer = spec.number(3, 1);
  if (inner < 0.0F || outer <= 0.0F || inner > outer || outer > 90.0F) {
    spec.fail("the angles must satisfy 0 <= inner <= outer <= 90 degrees and outer > 0");
  }
  light.inner_angle = inner * kRadiansPerDegree;
  light.outer_angle = outer * kRadiansPerDegree;
}

void read_quad(const SpecFields& spec, Light& light) {
  light.edge_u = spec.vector(1);
  light.edge_v = spec.vector(2);
  light.intensity = spec.colour(3);
  const float sine_scale = light.edge_u.norm() * light.edge_v.norm();
  const float area = light.edge_u.cross(light.edge_v).norm();
  if (!(area > 1e-6F * sine_scale) || !std::isfinite(area)) {
    spec.fail("the edges u and v must be finite and span an area");
  }
}

}  // namespace

Light WorldLight::in(const Vec3d& origin) const {
  Light moved = light;
  if (light.kind != Light::Kind::kSun) moved.position = relative_to(origin, position);
  return moved;
}

WorldLight parse_light(std::string_view text) {
  const SpecFields spec("light", text, forms());
  WorldLight parsed;
  Light& light = parsed.light;
  light.kind = kKinds[spec.form()];
  if (light.kind != Light::Kind::kSun) parsed.position = spec.place(0);
  switch (light.kind) {
    case Light::Kind::kPoint:
      light.intensity = spec.colour(1);
      break;
    case Light::Kind::kSphere:
      light.intensity = spec.colour(1);
      light.radius = spec.number(2);
      if (!(light.radius > 0.0F)) spec.fail("the radius must be positive");
      break;
    case Light::Kind::kSpot:
      read_spot(spec, light);
      break;
    case Light::Kind::kQuad:
      read_quad(spec, light);
      break;
    case Light::Kind::kSun:
      light.direction = spec.unit_direction(0);
      light.intensity = spec.colour(1);
      break;
  }
  return parsed;
}

std::vector<Light> lights_in(const Vec3d& origin, std::span<const WorldLight> lights) {
  std::vector<Light> placed;
  placed.reserve(lights.size());
  for (const WorldLight& light : lights) placed.push_back(light.in(origin));
  return placed;
}

}  // namespace prt
