#include "player/gl/controls.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "player/view.h"

namespace prt::gl {
namespace {

constexpr float kRadiansPerPixel = 0.005F;
constexpr float kNearestToPole = 0.05F;  // radians
constexpr float kZoomStep = 0.9F;

/// An offset turned about `up` and then tilted, short of the poles.
Vec3f swung(const Vec3f& offset, const Vec3f& up, float around, float tilt) {
  const Vec3f axis = up.normalized();
  Vec3f turned = Eigen::AngleAxisf(around, axis) * offset;
  const float polar = std::acos(std::clamp(axis.dot(turned.normalized()), -1.0F, 1.0F));
  const float wanted = std::clamp(polar + tilt, kNearestToPole, kPi - kNearestToPole);
  const Vec3f side = axis.cross(turned);
  if (!(side.norm() > 0.0F)) return turned;
  return Eigen::AngleAxisf(wanted - polar, side.normalized()) * turned;
}

/// Intensity of the new kind for an irradiance like the old one's at a distance of `reach`.
Vec3f like_irradiance(const Light& from, Light::Kind to, float reach, float area) {
  const auto per_irradiance = [&](Light::Kind kind) {
    if (kind == Light::Kind::kSun) return 1.0F;
    return kind == Light::Kind::kQuad ? reach * reach / area : reach * reach;
  };
  return from.intensity * per_irradiance(to) / per_irradiance(from.kind);
}

}  // namespace

SceneCamera orbited(const SceneCamera& camera, const Drag& drag) {
  SceneCamera moved = camera;
  moved.eye = camera.target + swung(camera.eye - camera.target, camera.up,
                                    -kRadiansPerPixel * drag.x, -kRadiansPerPixel * drag.y);
  return moved;
}

SceneCamera turned(const SceneCamera& camera, const Drag& drag) {
  SceneCamera moved = camera;
  moved.target = camera.eye + swung(camera.target - camera.eye, camera.up,
                                    -kRadiansPerPixel * drag.x, kRadiansPerPixel * drag.y);
  return moved;
}

SceneCamera walked(const SceneCamera& camera, const Vec3f& step) {
  const Eigen::Matrix3f axes = camera_axes(camera).cast<float>();
  const Vec3f move =
      step.x() * axes.col(0) + step.y() * camera.up.normalized() - step.z() * axes.col(2);
  SceneCamera moved = camera;
  moved.eye += move;
  moved.target += move;
  return moved;
}

SceneCamera zoomed(const SceneCamera& camera, float steps) {
  SceneCamera moved = camera;
  moved.eye = camera.target + std::pow(kZoomStep, steps) * (camera.eye - camera.target);
  return moved;
}

SceneCamera turntable(const SceneCamera& camera, float turns) {
  SceneCamera moved = camera;
  moved.eye = camera.target + Eigen::AngleAxisf(2.0F * kPi * turns, camera.up.normalized()) *
                                  (camera.eye - camera.target);
  return moved;
}

Light dragged(const Light& light, const Drag& drag, bool depth, const SceneCamera& camera,
              int image_height) {
  Light moved = light;
  const Eigen::Matrix3f axes = camera_axes(camera).cast<float>();
  if (light.kind == Light::Kind::kSun) {
    moved.direction = (Eigen::AngleAxisf(kRadiansPerPixel * drag.x, axes.col(1)) *
                       Eigen::AngleAxisf(kRadiansPerPixel * drag.y, axes.col(0)) * light.direction)
                          .normalized();
    return moved;
  }
  const float away = std::max(1e-3F, (camera.eye - light.position).dot(axes.col(2)));
  const float metres =
      2.0F * away / (static_cast<float>(view_scale(camera)) * static_cast<float>(image_height));
  moved.position += depth ? Vec3f(drag.y * metres * axes.col(2))
                          : Vec3f(metres * (drag.x * axes.col(0) - drag.y * axes.col(1)));
  return moved;
}

Light as_kind(const Light& light, Light::Kind kind, float size) {
  if (light.kind == kind) return light;
  const float reach = 0.2F * size;
  const float edge = 0.08F * size;
  Light changed = light;
  changed.kind = kind;
  changed.intensity = like_irradiance(light, kind, reach, edge * edge);
  if (!(changed.radius > 0.0F)) changed.radius = 0.02F * size;
  if (!(changed.outer_angle > 0.0F)) {
    changed.inner_angle = 0.5F;
    changed.outer_angle = 0.7F;
  }
  if (changed.edge_u.isZero() || changed.edge_v.isZero()) {
    changed.edge_u = edge * Vec3f::UnitX();
    changed.edge_v = edge * Vec3f::UnitZ();  // u × v points down
  }
  return changed;
}

}  // namespace prt::gl
