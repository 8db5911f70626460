// Random points and normals for tests of neighbour search, thinning and clusters.
#pragma once

#include <vector>

#include "base/random.h"
#include "base/types.h"

namespace prt::test {

struct PointCloud {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<float> curvatures;
  std::vector<std::uint64_t> priorities;
};

/// Uniform in the unit cube, normals uniform over the sphere, flat.
inline PointCloud random_cloud(std::size_t count, std::uint64_t stream) {
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(stream, i);
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    const float u = random.uniform(), v = random.uniform();
    cloud.positions.emplace_back(x, y, z);
    cloud.normals.push_back(sphere_direction(u, v));
    cloud.curvatures.push_back(0.0F);
    const std::uint64_t high = random.bits();
    cloud.priorities.push_back(high << 32 | random.bits());
  }
  return cloud;
}

/// Uniform over a sphere of radius 1, normals outwards: a surface that turns everywhere.
inline PointCloud sphere_cloud(std::size_t count, std::uint64_t stream) {
  PointCloud cloud = random_cloud(count, stream);
  cloud.positions = cloud.normals;
  return cloud;
}

}  // namespace prt::test
