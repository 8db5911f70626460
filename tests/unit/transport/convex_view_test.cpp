// Which clusters see everything: rooms of every kind, looked at by the rays of a real bake.
#include "transport/convex_view.h"

#include <gtest/gtest.h>

#include "bases/depth_basis.h"
#include "methods/lb/lb.h"
#include "statistical/test_scenes.h"
#include "support/partial_bake.h"

namespace prt {
namespace {

const Vec3f kHigh(2.0F, 1.5F, 3.0F);

OptionValues few_rays() {
  OptionValues options = test::default_options(lb_method());
  options.set("samples.count", 300);
  options.set("rays.directions", 144);
  return options;
}

struct Views {
  SampleSet samples;
  std::vector<std::optional<MatrixF>> walls;  ///< of each cluster
  [[nodiscard]] std::size_t empty() const {
    return std::ranges::count_if(walls, [](const auto& w) { return w.has_value(); });
  }
};

Views look(Scene scene, const Vec3f& start, int cluster_size = 50) {
  test::finish(scene);
  OptionValues options = few_rays();
  options.set("samples.start", {start.x(), start.y(), start.z()});
  options.set("samples.cluster_size", cluster_size);
  test::InProcessBake bake(scene, options);
  test::run_kinds(bake, lb_method(), test::kSamplingAndRays);
  Views views{test::samples_of(bake), {}};
  for (std::size_t c = 0; c < views.samples.clusters(); ++c) {
    const auto rays = bake.result(numbered("rays", c));
    views.walls.push_back(
        convex_walls(views.samples, HemisphereDirections(rays->attribute<int>("directions")),
                     {views.samples.cluster_begin[c], views.samples.cluster_begin[c + 1],
                      rays->values<std::uint16_t>("distance"),
                      rays->values<std::uint32_t>("sender"), rays->attribute<float>("bound")}));
  }
  return views;
}

Scene room() {
  Scene scene;
  test::add_box(scene, Vec3f::Zero(), kHigh, test::add_material(scene, Vec3f::Constant(0.5F)));
  return scene;
}

TEST(ConvexWalls, AreThoseOfAnEmptyRoom) {
  const Views views = look(room(), 0.4F * kHigh);
  ASSERT_GE(views.walls.size(), 4U);
  for (const auto& walls : views.walls) {
    ASSERT_TRUE(walls);
    ASSERT_GE(walls->rows(), 5);
    ASSERT_LE(walls->rows(), 6);
    for (Eigen::Index w = 0; w < walls->rows(); ++w) {
      const Vec3f normal = walls->block<1, 3>(w, 0).transpose();
      Eigen::Index axis = 0;
      EXPECT_NEAR(normal.cwiseAbs().maxCoeff(&axis), 1.0F, 1e-6F);
      EXPECT_NEAR((*walls)(w, 3), normal[axis] > 0.0F ? kHigh[axis] : 0.0F, 1e-5F);
    }
  }
}

TEST(ConvexWalls, AreNotThoseOfARoomWithAnythingInIt) {
  for (const float size : {0.4F, 0.1F}) {
    Scene scene = room();
    const Vec3f corner(0.9F, 0.6F, 1.4F);
    // Front sides outwards: the corners are exchanged.
    test::add_box(scene, corner + Vec3f::Constant(size), corner, 0);
    const Views views = look(scene, 0.2F * kHigh);
    EXPECT_EQ(views.empty(), 0U) << size;
  }
}

TEST(ConvexWalls, ANicheInAWallIsNotConvex) {
  Scene scene;
  const auto grey = test::add_material(scene, Vec3f::Constant(0.5F));
  // The floor has a sunken half: the room's outline is an L.
  const Vec3f x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  test::add_quad(scene, {0, 0, 0}, z, x, grey);
  test::add_quad(scene, {1, -1, 0}, z, x, grey);
  test::add_quad(scene, {1, -1, 0}, y, z, grey);
  test::add_quad(scene, {0, 1, 0}, 2.0F * x, z, grey);
  test::add_quad(scene, {0, 0, 0}, y, z, grey);
  test::add_quad(scene, {2, -1, 0}, z, 2.0F * y, grey);
  for (const float depth : {0.0F, 1.0F}) {
    test::add_quad(scene, {0, 0, depth}, x, y, grey);
    test::add_quad(scene, {1, -1, depth}, x, 2.0F * y, grey);
  }
  const Views views = look(scene, {1.5F, 0.5F, 0.5F});
  EXPECT_LT(views.empty(), views.walls.size());
  for (std::size_t c = 0; c < views.walls.size(); ++c) {
    if (!views.walls[c]) continue;
    // Whoever has walls sees all within them: nothing of the upper floor's edge.
    for (std::uint32_t s = views.samples.cluster_begin[c]; s < views.samples.cluster_begin[c + 1];
         ++s) {
      EXPECT_GE(views.samples.positions[s].x(), 1.0F - 1e-3F);
    }
  }
}

TEST(ConvexWalls, AnOpenRoomNeedsDepths) {
  Scene scene = room();
  scene.triangles.resize(scene.triangles.size() - 2);  // one side is gone
  EXPECT_EQ(look(scene, 0.4F * kHigh).empty(), 0U);
}

TEST(ConvexWalls, NothingIsInTheWayOfAFlatFloor) {
  Scene scene;
  test::add_quad(scene, Vec3f::Zero(), {0, 0, 1}, {1, 0, 0},
                 test::add_material(scene, Vec3f::Constant(0.5F)));
  const Views views = look(scene, {0.5F, 0.7F, 0.5F});
  ASSERT_EQ(views.empty(), views.walls.size());
  for (const auto& walls : views.walls) EXPECT_EQ(walls->rows(), 0);
}

TEST(ConvexWalls, AnotherRoomBehindAWallIsNoHindrance) {
  Scene scene = room();
  test::add_box(scene, Vec3f(2.2F, 0, 0), Vec3f(4.2F, 2.5F, 3.0F), 0);
  const Views views = look(scene, 0.4F * kHigh);
  EXPECT_EQ(views.empty(), views.walls.size());
}

TEST(ConvexWalls, AreNotKnownWhereNoRayGetsToTheEnd) {
  // So long a corridor that rays along it meet its sides first.
  Scene scene;
  test::add_box(scene, Vec3f::Zero(), {100, 1, 1},
                test::add_material(scene, Vec3f::Constant(0.5F)));
  const Views views = look(scene, {50, 0.5F, 0.5F}, 8);
  std::size_t inner = 0;
  for (std::uint32_t c = 0; c < views.walls.size(); ++c) {
    bool far_from_ends = true;
    for (std::uint32_t s = views.samples.cluster_begin[c]; s < views.samples.cluster_begin[c + 1];
         ++s) {
      const float x = views.samples.positions[s].x();
      far_from_ends = far_from_ends && x > 20.0F && x < 80.0F;
    }
    if (!far_from_ends) continue;
    ++inner;
    EXPECT_FALSE(views.walls[c]) << c;
  }
  EXPECT_GT(inner, 0U);
}

TEST(WallVisibility, EndsAtTheWalls) {
  MatrixF walls(2, 4);
  walls << 1, 0, 0, 2, 0, 1, 0, 3;
  const Vec3f p(1, 1, 1);
  constexpr float kBound = 10.0F;
  const auto seen = [&](const Vec3f& light) {
    return wall_visibility(walls, p, (light - p).normalized(), (light - p).norm(), kBound);
  };
  EXPECT_EQ(seen({1.9F, 2.9F, 5}), 1.0F);
  EXPECT_EQ(seen({2.0F, 1, 5}), 1.0F);  // a lamp on the wall
  EXPECT_EQ(seen({2.01F, 1, 5}), 0.0F);
  EXPECT_EQ(seen({1, 3.01F, 5}), 0.0F);
  EXPECT_EQ(seen({-50, -50, 5}), 1.0F);
  const auto sun = [&](const Vec3f& d) { return wall_visibility(walls, p, d, kInfinity, kBound); };
  EXPECT_EQ(sun(Vec3f::UnitX()), 0.0F);
  EXPECT_EQ(sun(Vec3f(0.001F, 0, 1).normalized()), 0.0F);
  EXPECT_EQ(sun(-Vec3f::UnitX()), 1.0F);
  EXPECT_EQ(sun(Vec3f::UnitZ()), 1.0F);
  EXPECT_EQ(wall_visibility(MatrixF(0, 4), p, Vec3f::UnitX(), kInfinity, kBound), 1.0F);
}

}  // namespace
}  // namespace prt
