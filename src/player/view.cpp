#include "player/view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "player/rasteriser.h"

namespace prt {

Eigen::Matrix3d camera_axes(const SceneCamera& camera) {
  const Eigen::Vector3d view = (camera.eye - camera.target).cast<double>();
  const Eigen::Vector3d back = view.norm() > 0.0 ? view.normalized() : Eigen::Vector3d::UnitZ();
  Eigen::Vector3d right = camera.up.cast<double>().cross(back);
  if (!(right.norm() > 1e-6)) right = back.unitOrthogonal();  // looking straight up or down
  Eigen::Matrix3d axes;
  axes.col(0) = right.normalized();
  axes.col(1) = back.cross(axes.col(0));
  axes.col(2) = back;
  return axes;
}

double view_scale(const SceneCamera& camera) {
  return 1.0 / std::tan(0.5 * std::clamp<double>(camera.vertical_fov, 1e-3, 3.1));
}

View::View(const SceneCamera& camera, int width, int height)
    : to_camera_(camera_axes(camera).transpose()),
      eye_(camera.eye.cast<double>()),
      scale_(view_scale(camera)),
      aspect_(static_cast<double>(width) / height) {}

Projected View::project(const Vec3f& point) const {
  const Eigen::Vector3d p = to_camera_ * (point.cast<double>() - eye_);
  return {scale_ * p.x(), -scale_ * p.y(), -p.z()};
}

Vec3f view_direction(const SceneCamera& camera, int width, int height, float x, float y) {
  const double half = 1.0 / view_scale(camera);
  const double right = (2.0 * x / width - 1.0) * half * width / height;
  const double up = (1.0 - 2.0 * y / height) * half;
  return (camera_axes(camera) * Eigen::Vector3d(right, up, -1.0)).normalized().cast<float>();
}

}  // namespace prt
