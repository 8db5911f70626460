#include <gtest/gtest.h>

#include <vector>

#include "scene/embree/embree_ray_caster.h"
#include "statistical/test_scenes.h"
#include "transport/particles.h"

namespace prt {
namespace {

constexpr std::uint64_t kStreams = 4;  // more than one, or luck would do

bool inside(const Vec3f& p, const Vec3f& low, const Vec3f& high) {
  return (p.array() > low.array()).all() && (p.array() < high.array()).all();
}

std::vector<Vec3f> starts_of(Scene& scene) {
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  std::vector<Vec3f> starts;
  for (std::uint64_t s = 0; s < kStreams; ++s) starts.push_back(find_start(scene, *caster, s));
  return starts;
}

// A solid's inside sees its faces from behind; here it is half of the bounding box.
TEST(FindStart, IsNotInsideASolid) {
  Scene scene;
  const auto material = test::add_material(scene, Vec3f::Constant(0.5F));
  test::add_box(scene, Vec3f::Zero(), Vec3f::Constant(2.0F), material);
  const Vec3f low = Vec3f::Constant(0.2F), high = Vec3f::Constant(1.8F);
  test::add_box(scene, high, low, material);  // corners swapped: front sides outwards
  for (const Vec3f& start : starts_of(scene)) EXPECT_FALSE(inside(start, low, high));
}

// The gaps have twice the room's volume, and from them too nothing but front sides is seen.
TEST(FindStart, IsInTheRoomAndNotInTheGapsBehindIt) {
  Scene scene;
  const auto material = test::add_material(scene, Vec3f::Constant(0.5F));
  const Vec3f room = Vec3f::Constant(4.0F);
  test::add_box(scene, Vec3f::Zero(), room, material);
  constexpr int kGaps = 20;
  constexpr float kGap = 0.4F;
  constexpr float kWall = 0.01F;  // or a wall's back would be seen from the other side
  for (int i = 0; i < kGaps; ++i) {
    const float x = 4.0F + kGap * static_cast<float>(i);
    test::add_box(scene, {x + kWall, 0.0F, 0.0F}, {x + kGap, 4.0F, 4.0F}, material);
  }
  for (const Vec3f& start : starts_of(scene)) EXPECT_TRUE(inside(start, Vec3f::Zero(), room));
}

// All of the bounding box is inside.
TEST(FindStart, IsOutsideASolidThatStandsAlone) {
  Scene scene;
  const Vec3f low = Vec3f::Zero(), high = Vec3f::Ones();
  test::add_box(scene, high, low, test::add_material(scene, Vec3f::Constant(0.5F)));
  for (const Vec3f& start : starts_of(scene)) EXPECT_FALSE(inside(start, low, high));
}

// Of the bounding box a hundred-millionth is room; the rest sees next to nothing.
TEST(FindStart, IsInTheRoomAndNotByTheSpeckFarAway) {
  Scene scene;
  const auto material = test::add_material(scene, Vec3f::Constant(0.5F));
  const Vec3f room = Vec3f::Constant(4.0F);
  test::add_box(scene, Vec3f::Zero(), room, material);
  const Vec3f speck = Vec3f::Constant(1000.0F);
  test::add_box(scene, speck + Vec3f::Constant(0.01F), speck, material);
  for (const Vec3f& start : starts_of(scene)) EXPECT_TRUE(inside(start, Vec3f::Zero(), room));
}

TEST(FindStart, DependsOnItsStreamAlone) {
  Scene scene;
  test::add_box(scene, Vec3f::Zero(), Vec3f::Ones(),
                test::add_material(scene, Vec3f::Constant(0.5F)));
  const auto starts = starts_of(scene);
  EXPECT_EQ(starts_of(scene), starts);
  EXPECT_NE(starts[0], starts[1]);
}

}  // namespace
}  // namespace prt
