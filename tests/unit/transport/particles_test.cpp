#include "transport/particles.h"

#include <gtest/gtest.h>

#include "scene/embree/embree_ray_caster.h"
#include "scene/load.h"

namespace prt {
namespace {

// All solids of the gallery have their front sides outwards, so a particle that meets a back side
// is inside one. Many of its boxes touch and share no vertices: some rays slip through their edges.
TEST(Particles, DoNotEnterSolids) {
  constexpr std::size_t kWanted = 1'000'000;  // 17 of them inside, if the way back is not looked at
  const Scene scene = load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/gallery.glb");
  const auto caster = make_embree_ray_caster(scene);
  ParticleSettings settings;
  settings.start = scene.camera->eye;
  settings.wanted = kWanted;
  settings.ray_budget = 10 * kWanted;
  const SurfacePoints points = trace_particles(scene, *caster, settings);
  ASSERT_EQ(points.size(), kWanted);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.normals[i].dot(triangle_normal(scene, points.triangles[i])) < 0.0F) ++inside;
  }
  EXPECT_EQ(inside, 0U);
}

}  // namespace
}  // namespace prt
