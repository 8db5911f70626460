#include "transport/direct.h"

#include <algorithm>

namespace prt {

MatrixF direct_irradiance(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                          std::uint32_t begin, std::uint32_t end, std::span<const Vec3f> lights,
                          float nearest) {
  MatrixF irradiance = MatrixF::Zero(static_cast<Eigen::Index>(lights.size()), end - begin);
  std::vector<Vec3f> origins;
  for (std::uint32_t s = begin; s < end; ++s) {
    origins.push_back(offset_origin(scene, samples.positions[s], samples.normals[s]));
  }
  std::vector<Ray> rays;
  std::vector<std::uint32_t> targets;
  std::vector<std::uint8_t> blocked;
  for (std::size_t l = 0; l < lights.size(); ++l) {
    rays.clear();
    targets.clear();
    // Light-major, from the light outwards: the rays of a packet stay together.
    for (std::uint32_t s = begin; s < end; ++s) {
      const Vec3f to_sample = origins[s - begin] - lights[l];
      if (samples.normals[s].dot(to_sample) >= 0.0F) continue;
      const float distance = to_sample.norm();
      rays.push_back({lights[l], to_sample / distance, 0.0F, distance});
      targets.push_back(s - begin);
    }
    blocked.assign(rays.size(), 0);
    caster.occluded(rays, blocked);
    for (std::size_t k = 0; k < rays.size(); ++k) {
      if (blocked[k]) continue;
      const float cosine = -samples.normals[begin + targets[k]].dot(rays[k].direction);
      const float r = std::max(rays[k].t_far, nearest);
      irradiance(static_cast<Eigen::Index>(l), targets[k]) = cosine / (r * r);
    }
  }
  return irradiance;
}

}  // namespace prt
