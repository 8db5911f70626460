#include "base/random.h"

#include <cmath>

#include "base/hash.h"

namespace prt {

std::uint64_t stream_key(std::uint64_t seed, std::string_view name) {
  return Hasher().add_values(std::span<const std::uint64_t>(&seed, 1)).add(name).digest().low;
}

Mat3f frame_from_normal(const Vec3f& n) {
  const float sign = std::copysign(1.0F, n.z());
  const float a = -1.0F / (sign + n.z());
  const float b = n.x() * n.y() * a;
  Mat3f frame;
  frame.col(0) = Vec3f(1.0F + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
  frame.col(1) = Vec3f(b, sign + n.y() * n.y() * a, -n.y());
  frame.col(2) = n;
  return frame;
}

Vec3f cosine_direction(const Vec3f& normal, float u, float v) {
  const float radius = std::sqrt(u);
  const float phi = 2.0F * kPi * v;
  const Vec3f local(radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1.0F - u));
  return (frame_from_normal(normal) * local).normalized();
}

Vec3f sphere_direction(float u, float v) {
  const float z = 1.0F - 2.0F * u;
  const float radius = std::sqrt(std::max(0.0F, 1.0F - z * z));
  const float phi = 2.0F * kPi * v;
  return {radius * std::cos(phi), radius * std::sin(phi), z};
}

}  // namespace prt
