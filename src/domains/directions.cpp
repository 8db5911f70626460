#include "domains/directions.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"

namespace prt {

namespace {

/// Largest divisor of count that is at most its root, if the other side is below twice as long.
int short_side(int count) {
  for (int side = static_cast<int>(std::sqrt(static_cast<double>(count))); side >= 1; --side) {
    if (count % side == 0) return 2 * side > count / side || count == 1 ? side : 0;
  }
  return 0;
}

// Concentric map (Shirley & Chiu 1997), square [-1,1]² to unit disk, area-preserving.
Vec2f square_to_disk(float a, float b) {
  if (a == 0.0F && b == 0.0F) return Vec2f::Zero();
  float r = 0.0F;
  float phi = 0.0F;
  if (std::abs(a) > std::abs(b)) {
    r = a;
    phi = kPi / 4.0F * (b / a);
  } else {
    r = b;
    phi = kPi / 2.0F - kPi / 4.0F * (a / b);
  }
  return {r * std::cos(phi), r * std::sin(phi)};
}

Vec2f disk_to_square(float x, float y) {
  const float r = std::sqrt(x * x + y * y);
  if (r == 0.0F) return Vec2f::Zero();
  const float ax = std::abs(x);
  const float ay = std::abs(y);
  const float angle = std::atan2(std::min(ax, ay), std::max(ax, ay));  // 0..π/4 off the major axis
  const float minor = r * angle * (4.0F / kPi);
  const float u = ax >= ay ? r : minor;
  const float v = ax >= ay ? minor : r;
  return {std::copysign(u, x), std::copysign(v, y)};
}

}  // namespace

int HemisphereDirections::nearest_count(int count) {
  count = std::clamp(count, 1, 1 << 30);
  for (int step = 0;; ++step) {  // ends at the latest at 1
    if (count - step >= 1 && short_side(count - step) > 0) return count - step;
    if (short_side(count + step) > 0) return count + step;
  }
}

HemisphereDirections::HemisphereDirections(int count) {
  height_ = count >= 1 ? short_side(count) : 0;
  if (height_ == 0) {
    throw UserError(std::to_string(count) + " directions form no grid of two like sides");
  }
  width_ = count / height_;
  directions_.reserve(count);
  double sum = 0.0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const float a = (2.0F * static_cast<float>(x) + 1.0F) / static_cast<float>(width_) - 1.0F;
      const float b = (2.0F * static_cast<float>(y) + 1.0F) / static_cast<float>(height_) - 1.0F;
      const Vec2f disk = square_to_disk(a, b);
      // Equal areas of the disk are equal solid angles when z = 1 - r² and the radius is stretched.
      const float r2 = disk.squaredNorm();
      const float stretch = std::sqrt(std::max(0.0F, 2.0F - r2));
      directions_.push_back(Vec3f(disk.x() * stretch, disk.y() * stretch, 1.0F - r2).normalized());
      sum += directions_.back().z();
    }
  }
  weights_.reserve(count);
  for (const Vec3f& d : directions_) weights_.push_back(static_cast<float>(d.z() / sum));
}

HemisphereDirections::Lookup HemisphereDirections::lookup(const Vec3f& local) const {
  const float r2 = std::clamp(1.0F - local.z(), 0.0F, 1.0F);
  const float stretch = std::sqrt(std::max(1e-12F, 2.0F - r2));
  const Vec2f square = disk_to_square(local.x() / stretch, local.y() / stretch);
  const auto cell = [](float s, int n) {  // continuous cell coordinate, centres at integers
    return std::clamp((s + 1.0F) * 0.5F * static_cast<float>(n) - 0.5F, 0.0F,
                      static_cast<float>(n - 1));
  };
  const float fx = cell(square.x(), width_);
  const float fy = cell(square.y(), height_);
  const int x0 = std::min(static_cast<int>(fx), std::max(0, width_ - 2));
  const int y0 = std::min(static_cast<int>(fy), std::max(0, height_ - 2));
  const int x1 = std::min(x0 + 1, width_ - 1);
  const int y1 = std::min(y0 + 1, height_ - 1);
  const float wx = fx - static_cast<float>(x0);
  const float wy = fy - static_cast<float>(y0);
  return {{y0 * width_ + x0, y0 * width_ + x1, y1 * width_ + x0, y1 * width_ + x1},
          {(1 - wx) * (1 - wy), wx * (1 - wy), (1 - wx) * wy, wx * wy}};
}

}  // namespace prt
