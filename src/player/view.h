// World to image. Internal to player/.
#pragma once

#include "scene/scene.h"

namespace prt {

/// Camera axes in double precision: columns right, up, back (against the view).
Eigen::Matrix3d camera_axes(const SceneCamera& camera);

/// 1 / tan(half the vertical field of view), the field kept between narrowest and widest.
double view_scale(const SceneCamera& camera);

/// A point as the camera sees it: x right, y down in units of the image plane at depth 1, scaled so
/// that the image spans [-aspect, aspect] × [-1, 1]; w is the depth along the view (m).
struct Projected {
  double x = 0.0;  ///< times w
  double y = 0.0;  ///< times w
  double w = 0.0;
};

class View {
 public:
  View(const SceneCamera& camera, int width, int height);
  [[nodiscard]] Projected project(const Vec3f& point) const;
  [[nodiscard]] double aspect() const { return aspect_; }

 private:
  Eigen::Matrix3d to_camera_;
  Eigen::Vector3d eye_;
  double scale_;  // 1 / tan(half the vertical field of view)
  double aspect_;
};

}  // namespace prt
