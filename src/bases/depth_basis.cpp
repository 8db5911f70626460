#include "bases/depth_basis.h"

namespace prt {

std::uint16_t pack_depth(float t, float bound, bool escaped) {
  if (escaped) return kEscapedDepth;
  return static_cast<std::uint16_t>(std::lround(encode_depth(t, bound) * 65534.0F));
}

float wall_visibility(const MatrixF& walls, const Vec3f& inside, const Vec3f& to_light,
                      float distance, float bound) {
  for (Eigen::Index w = 0; w < walls.rows(); ++w) {
    const Vec3f normal = walls.block<1, 3>(w, 0).transpose();
    // NaN for a light infinitely far along the wall, which does not pass through it.
    const float beyond = normal.dot(inside) - walls(w, 3) + distance * normal.dot(to_light);
    if (beyond > kWallSlack * bound) return 0.0F;
  }
  return 1.0F;
}

}  // namespace prt
