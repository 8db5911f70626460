#include "scene/ray_caster.h"

namespace prt {

bool RayCaster::visible(const Vec3f& from, const Vec3f& to) const {
  const Vec3f offset = to - from;
  const float distance = offset.norm();
  if (!(distance > 0.0F)) return true;
  const Ray ray{from, offset / distance, 0.0F, distance};
  std::uint8_t blocked = 0;
  occluded({&ray, 1}, {&blocked, 1});
  return blocked == 0;
}

}  // namespace prt
