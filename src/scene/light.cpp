#include "scene/light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace prt {
namespace {

IncidentLight from_point(const Vec3f& position, const Vec3f& intensity, const Vec3f& p) {
  const Vec3f offset = position - p;
  const float distance = offset.norm();
  if (!(distance > 0.0F)) return {};
  return {offset / distance, distance, intensity / (distance * distance)};
}

IncidentLight from_spot(const Light& light, const Vec3f& p) {
  IncidentLight incident = from_point(light.position, light.intensity, p);
  // KHR_lights_punctual, "inner and outer cone angles".
  const float inner = std::cos(light.inner_angle);
  const float outer = std::cos(light.outer_angle);
  const float cosine = -light.direction.dot(incident.to_light);
  const float falloff = std::clamp((cosine - outer) / std::max(0.001F, inner - outer), 0.0F, 1.0F);
  incident.irradiance *= falloff * falloff;
  return incident;
}

/// Uniform over the directions in which the sphere is seen: their solid angle is 2π(1 − cos θ_max)
/// with sin θ_max = R/d (Shirley, Wang & Zimmerman 1996). From inside the sphere glows all around,
/// which continues what is seen at its surface.
IncidentLight from_sphere(const Light& light, const Vec3f& p, float u, float v) {
  const Vec3f radiance = light.intensity / (kPi * light.radius * light.radius);
  const Vec3f offset = light.position - p;
  const float distance = offset.norm();
  if (distance <= light.radius) {
    const Vec3f direction = sphere_direction(u, v);
    const float along = offset.dot(direction);
    const float off_axis2 = std::max(0.0F, distance * distance - along * along);
    const float half_chord = std::sqrt(std::max(0.0F, light.radius * light.radius - off_axis2));
    return {direction, along + half_chord, radiance * (4.0F * kPi)};
  }
  const float sine2_max = (light.radius / distance) * (light.radius / distance);
  const float cosine_max = std::sqrt(std::max(0.0F, 1.0F - sine2_max));
  const float one_minus_cosine_max = sine2_max / (1.0F + cosine_max);
  const float one_minus_cosine = u * one_minus_cosine_max;
  const float cosine = 1.0F - one_minus_cosine;
  const float sine2 = one_minus_cosine * (1.0F + cosine);
  const float sine = std::sqrt(sine2);
  const float angle = 2.0F * kPi * v;
  const Vec3f local(sine * std::cos(angle), sine * std::sin(angle), cosine);
  const Vec3f direction = (frame_from_normal(offset / distance) * local).normalized();
  const float half_chord2 = light.radius * light.radius - distance * distance * sine2;
  const float to_surface = distance * cosine - std::sqrt(std::max(0.0F, half_chord2));
  return {direction, to_surface, radiance * (2.0F * kPi * one_minus_cosine_max)};
}

IncidentLight from_quad(const Light& light, const Vec3f& p, float u, float v) {
  const Vec3f point = light.position + (u - 0.5F) * light.edge_u + (v - 0.5F) * light.edge_v;
  IncidentLight incident = from_point(point, light.intensity, p);
  const Vec3f area_vector = light.edge_u.cross(light.edge_v);
  incident.irradiance *= std::max(0.0F, -area_vector.dot(incident.to_light));
  return incident;
}

}  // namespace

IncidentLight incident_light(const Light& light, const Vec3f& p, float u, float v) {
  switch (light.kind) {
    case Light::Kind::kPoint:
      return from_point(light.position, light.intensity, p);
    case Light::Kind::kSphere:
      if (!(light.radius > 0.0F)) return from_point(light.position, light.intensity, p);
      return from_sphere(light, p, u, v);
    case Light::Kind::kSpot:
      return from_spot(light, p);
    case Light::Kind::kQuad:
      return from_quad(light, p, u, v);
    case Light::Kind::kSun:
      return {-light.direction, kInfinity, light.intensity};
  }
  return {};
}

bool is_punctual(const Light& light) {
  return light.kind == Light::Kind::kPoint || light.kind == Light::Kind::kSpot ||
         light.kind == Light::Kind::kSun;
}

}  // namespace prt
