// An empty box as scene, with samples on a grid over its walls.
#pragma once

#include "base/random.h"
#include "domains/samples.h"
#include "statistical/test_scenes.h"

namespace prt::test {

inline constexpr float kBoxSide = 2.0F;  // m
inline constexpr int kBoxGrid = 12;      // samples along each edge of a wall

inline Scene box_room(float albedo) {
  Scene scene;
  add_box(scene, Vec3f::Zero(), Vec3f::Constant(kBoxSide),
          add_material(scene, Vec3f::Constant(albedo)));
  finish(scene);
  return scene;
}

/// One cluster per wall.
inline SampleSet box_samples() {
  SampleSet samples;
  const float step = kBoxSide / kBoxGrid;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {0.0F, kBoxSide}) {
      samples.cluster_begin.push_back(static_cast<std::uint32_t>(samples.size()));
      for (int i = 0; i < kBoxGrid * kBoxGrid; ++i) {
        const int column = i % kBoxGrid;
        const int row = i / kBoxGrid;
        Vec3f p, n = Vec3f::Zero();
        p[axis] = side;
        p[(axis + 1) % 3] = (static_cast<float>(column) + 0.5F) * step;
        p[(axis + 2) % 3] = (static_cast<float>(row) + 0.5F) * step;
        n[axis] = side > 0.0F ? -1.0F : 1.0F;
        samples.positions.push_back(p);
        samples.normals.push_back(n);
        samples.tangents.push_back(frame_from_normal(n).col(0));
        samples.areas.push_back(step * step);
        samples.radii.push_back(step);
        samples.triangles.push_back(0);
      }
    }
  }
  samples.cluster_begin.push_back(static_cast<std::uint32_t>(samples.size()));
  return samples;
}

}  // namespace prt::test
