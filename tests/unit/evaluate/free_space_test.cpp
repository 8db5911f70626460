#include "transport/free_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/embree/embree_ray_caster.h"
#include "unit/evaluate/box_room.h"

namespace prt {
namespace {

TEST(FreeSpace, PositionsKeepTheirDistanceAndDependOnTheirNumberAlone) {
  constexpr float kClearance = 0.3F;
  const Scene scene = test::box_room(0.5F);
  const auto caster = make_embree_ray_caster(scene);
  const SampleSet samples = test::box_samples();
  const auto all = free_positions(scene, *caster, samples, kClearance, 5, 0, 100);
  ASSERT_EQ(all.size(), 100U);
  Vec3f low = all[0], high = all[0];
  for (const Vec3f& p : all) {
    EXPECT_GE(p.minCoeff(), kClearance);
    EXPECT_LE(p.maxCoeff(), test::kBoxSide - kClearance);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Uniform: 100 positions come within a tenth of the ends of each axis.
  EXPECT_LT(low.maxCoeff(), kClearance + 0.1F * test::kBoxSide);
  EXPECT_GT(high.minCoeff(), test::kBoxSide - kClearance - 0.1F * test::kBoxSide);
  const auto part = free_positions(scene, *caster, samples, kClearance, 5, 40, 10);
  for (std::size_t i = 0; i < part.size(); ++i) EXPECT_EQ(part[i], all[40 + i]);
}

TEST(FreeSpace, SolidsAndTheirInsidesAreNotFree) {
  Scene scene = test::box_room(0.5F);
  const Vec3f low = Vec3f::Constant(0.6F), high = Vec3f::Constant(1.6F);
  test::add_box(scene, low, high, 0);
  const auto caster = make_embree_ray_caster(scene);
  // All samples are on the outer walls: what is inside the inner box sees none of them.
  const auto all = free_positions(scene, *caster, test::box_samples(), 0.05F, 5, 0, 300);
  for (const Vec3f& p : all) {
    const bool inside = (p.array() > low.array()).all() && (p.array() < high.array()).all();
    EXPECT_FALSE(inside);
  }
}

/// A horizontal square, 10 m wide, front upwards, with samples on its top.
struct Field {
  Field() {
    test::add_quad(scene, {-5, 0, -5}, {0, 0, 10}, {10, 0, 0},
                   test::add_material(scene, Vec3f::Constant(0.5F)));
    test::finish(scene);
    for (int i = 0; i < 100; ++i) {
      samples.positions.emplace_back(static_cast<float>(i % 10) - 4.5F, 0.0F,
                                     static_cast<float>(i / 10) - 4.5F);
      samples.normals.push_back(Vec3f::UnitY());
    }
  }
  Scene scene;
  SampleSet samples;
};

// The box of a flat scene reaches below it as well, but from there no sample's front is seen.
TEST(FreeSpace, OverAFlatSceneIsAboveIt) {
  constexpr float kClearance = 0.1F;
  const Field field;
  const auto caster = make_embree_ray_caster(field.scene);
  const LightBox box = light_box(field.samples.positions);
  const float diagonal = std::sqrt(2.0F) * 9.0F;
  EXPECT_NEAR(box.high.y(), 0.05F * diagonal, 1e-5F);
  EXPECT_NEAR(box.low.y(), -0.05F * diagonal, 1e-5F);
  EXPECT_FLOAT_EQ(box.high.x(), 4.5F);
  float highest = 0.0F;
  for (const Vec3f& p :
       free_positions(field.scene, *caster, field.samples, kClearance, 5, 0, 200)) {
    EXPECT_GE(p.y(), kClearance);
    highest = std::max(highest, p.y());
  }
  EXPECT_GT(highest, 0.9F * box.high.y());
  // So flat a scene takes its clearance from its height: 5 · 0.1 of the diagonal, not all of it.
  EXPECT_NEAR(light_clearance(field.samples, 0.02F), 0.02F * 0.5F * samples_diagonal(field.samples),
              0.02F * diagonal * 0.01F);
}

TEST(FreeSpace, SaysWhenThereIsNone) {
  const Scene scene = test::box_room(0.5F);
  const auto caster = make_embree_ray_caster(scene);
  EXPECT_THROW(free_positions(scene, *caster, test::box_samples(), 1.1F, 5, 0, 1), UserError);
  EXPECT_THROW(free_positions(scene, *caster, SampleSet{}, 0.1F, 5, 0, 1), UserError);
}

}  // namespace
}  // namespace prt
