// Form factors and view factors in closed form.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/types.h"

namespace prt::test {

inline constexpr double kPiD = 3.14159265358979323846;

/// Form factor from a point to a parallel rectangle of full sides w, l, centred at distance h
/// (Howell, catalogue of view factors, B-3, four quarters).
inline double parallel_rectangle(double w, double l, double h) {
  const double a = 0.5 * w / h, b = 0.5 * l / h;
  const double ra = std::sqrt(1.0 + a * a), rb = std::sqrt(1.0 + b * b);
  return 4.0 / (2.0 * kPiD) * (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb));
}

/// View factor between equal rectangles x × y that face each other at distance 1 (Howell, C-11).
inline double facing_rectangles(double x, double y) {
  const double rx = std::sqrt(1.0 + x * x), ry = std::sqrt(1.0 + y * y);
  return 2.0 / (kPiD * x * y) *
         (std::log(rx * ry / std::sqrt(1.0 + x * x + y * y)) + x * ry * std::atan(x / ry) +
          y * rx * std::atan(y / rx) - x * std::atan(x) - y * std::atan(y));
}

/// View factor from a rectangle of depth w to one of height h at a right angle; their common edge
/// has length 1 (Howell, C-14).
inline double rectangles_at_right_angle(double w, double h) {
  const double a = w * w, b = h * h, r = std::sqrt(a + b);
  const double logs = std::log((1.0 + a) * (1.0 + b) / (1.0 + a + b)) +
                      a * std::log(a * (1.0 + a + b) / ((1.0 + a) * (a + b))) +
                      b * std::log(b * (1.0 + a + b) / ((1.0 + b) * (a + b)));
  return (w * std::atan(1.0 / w) + h * std::atan(1.0 / h) - r * std::atan(1.0 / r) + 0.25 * logs) /
         (kPiD * w);
}

/// Lambert's formula: irradiance over radiance of a convex polygon, its vertices relative to the
/// point, clockwise seen from there; what lies below the horizon is cut off.
inline double lambert_polygon(const std::vector<Vec3d>& vertices, const Vec3d& normal) {
  std::vector<Vec3d> above;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3d& a = vertices[i];
    const Vec3d& b = vertices[(i + 1) % vertices.size()];
    const double ha = a.dot(normal), hb = b.dot(normal);
    if (ha > 0.0) above.push_back(a);
    if (ha * hb < 0.0) above.push_back(a + ha / (ha - hb) * (b - a));
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < above.size(); ++i) {
    const Vec3d a = above[i].normalized(), b = above[(i + 1) % above.size()].normalized();
    const Vec3d across = a.cross(b);
    if (across.norm() == 0.0) continue;
    sum += 0.5 * std::atan2(across.norm(), a.dot(b)) * normal.dot(across.normalized());
  }
  return std::abs(sum);
}

}  // namespace prt::test
