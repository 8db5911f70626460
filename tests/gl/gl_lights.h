// Lights of every kind in the synthetic room.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scene/light.h"
#include "unit/package/synthetic_package.h"

namespace prt::test {

struct NamedLights {
  std::string name;
  std::vector<Light> lights;
};

inline std::vector<NamedLights> lights_of_every_kind() {
  const Vec3f size = SyntheticRoom().size;
  const Light point{.position = 0.45F * size, .intensity = {9, 8, 7}};
  const Light sphere{.kind = Light::Kind::kSphere,
                     .position = {1.2F, 2.0F, 3.5F},
                     .intensity = {6, 7, 8},
                     .radius = 0.3F};
  const Light spot{.kind = Light::Kind::kSpot,
                   .position = {3.0F, 2.6F, 1.0F},
                   .direction = Vec3f(-0.5F, -1.0F, 0.4F).normalized(),
                   .intensity = {12, 10, 8},
                   .inner_angle = 0.4F,
                   .outer_angle = 0.8F};
  const Light quad{.kind = Light::Kind::kQuad,
                   .position = {2.0F, 2.7F, 2.0F},
                   .intensity = {20, 18, 15},
                   .edge_u = {0.8F, 0, 0},
                   .edge_v = {0, 0, 0.6F}};
  const Light sun{.kind = Light::Kind::kSun,
                  .direction = Vec3f(0.3F, -1.0F, 0.2F).normalized(),
                  .intensity = {3, 3, 2}};
  return {{"point", {point}}, {"sphere", {sphere}}, {"spot", {spot}},
          {"quad", {quad}},   {"sun", {sun}},       {"all", {spot, point, quad, sphere, sun}}};
}

/// Open to the sky, with something in the way of light, so that there are shadows.
inline Scene room_with_a_table() {
  const Vec3f size = SyntheticRoom().size;
  Scene scene = rich_scene(size);
  scene.triangles.erase(scene.triangles.begin() + 2, scene.triangles.begin() + 4);  // the ceiling
  add_quad(scene, {1.2F, 0.9F, 1.5F}, {0, 0, 1.2F}, {1.4F, 0, 0}, 0, 7);
  add_quad(scene, {1.2F, 0.0F, 1.5F}, {0, 0.9F, 0}, {0, 0, 1.2F}, 1, 8);
  return scene;
}

}  // namespace prt::test
