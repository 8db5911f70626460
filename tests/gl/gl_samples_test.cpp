// Light at the samples: what the GL makes of a package's program against the CPU's answer.
#include <gtest/gtest.h>

#include "base/error.h"
#include "gl/gl_lights.h"
#include "player/gl/offscreen.h"
#include "player/gl/renderer.h"
#include "stability/small_bake.h"

namespace prt {
namespace {

using test::lights_of_every_kind;
using test::synthetic_room;

/// Sums in another order, sines and roots of another library.
constexpr double kRounding = 1e-3;
/// Where a light stands just at a reconstructed depth, rounding decides the whole of one of four
/// directions: so many of the samples may be off.
constexpr double kOnTheEdge = 1e-3;

double relative(const MatrixF& value, const MatrixF& expected) {
  return (value - expected).norm() / std::max(1e-30, double{expected.norm()});
}

/// Share of the samples that differ by more than rounding.
double share_off(const MatrixF& value, const MatrixF& expected) {
  const float scale = expected.cwiseAbs().maxCoeff();
  Eigen::Index off = 0;
  for (Eigen::Index i = 0; i < value.rows(); ++i) {
    const float allowed = float(kRounding) * (expected.row(i).norm() + float(kRounding) * scale);
    if (!((value.row(i) - expected.row(i)).norm() <= allowed)) ++off;
  }
  return static_cast<double>(off) / static_cast<double>(value.rows());
}

/// The sun shines into an open scene only.
void expect_same_light(const Package& package, const std::string& what, bool open = false) {
  const Evaluator cpu(package);
  gl::GlRenderer gl(package);
  for (const auto& [name, lights] : lights_of_every_kind()) {
    const SampleIrradiance expected = cpu.evaluate(lights);
    gl.set_lights(lights);
    ASSERT_EQ(expected.direct.norm() > 0.0F, open || name != "sun") << what << name;
    EXPECT_LE(relative(gl.direct(), expected.direct), kRounding) << what << name;
    EXPECT_LE(share_off(gl.direct(), expected.direct), kOnTheEdge) << what << name;
    EXPECT_LE(relative(gl.indirect(), expected.indirect), kRounding) << what << name;
  }
  gl.set_lights({});
  EXPECT_EQ(gl.direct().norm(), 0.0F) << what;
  EXPECT_EQ(gl.indirect().norm(), 0.0F) << what;
}

TEST(GlSamples, PlaysABakeAsTheCpuDoes) {
  const gl::OffscreenContext context;
  const test::SmallBake bake(test::room_with_a_table());
  expect_same_light(bake.package(), "bake, ", true);
}

TEST(GlSamples, PlaysIntegersOfEveryWidth) {
  const gl::OffscreenContext context;
  for (const int bits : {8, 16, 32}) {
    expect_same_light(synthetic_room({.albedo = {0.2F, 0.5F, 0.8F}, .bits = bits}),
                      std::to_string(bits) + " bits, ");
  }
}

TEST(GlSamples, PlaysOneChannelWallsAndNoShadows) {
  const gl::OffscreenContext context;
  expect_same_light(synthetic_room({.directions = 0, .channels = 1}), "grey, ", true);
  Package walls = synthetic_room();
  test::see_up_to_walls(walls, test::SyntheticRoom().size);
  for (const auto& block : walls.visibility->clusters) ASSERT_GT(block.walls.rows(), 0);
  const Evaluator cpu(walls);
  gl::GlRenderer gl(walls);
  // A light inside is seen by all that face it, one outside by none.
  for (const float at : {0.4F, 1.2F}) {
    Light light;
    light.position = at * test::SyntheticRoom().size;
    const SampleIrradiance expected = cpu.evaluate({&light, 1});
    gl.set_lights({&light, 1});
    EXPECT_LE(relative(gl.direct(), expected.direct), kRounding) << at;
    EXPECT_EQ(gl.direct().norm() > 0.0F, at < 1.0F);
  }
}

TEST(GlSamples, PlaysNearTransferAndSumsOfBothParts) {
  const gl::OffscreenContext context;
  for (const std::uint32_t channels : {3U, 1U}) {
    Package near = synthetic_room();
    test::add_near(near, channels);
    expect_same_light(near, "near, ");
    // Near transfer of light that has come once already.
    const auto n = static_cast<std::uint32_t>(near.samples.size());
    near.spaces.push_back({"twice", Space::Kind::kSampleIrradiance, n});
    near.spaces.push_back({"again", Space::Kind::kSampleIrradiance, n});
    near.program.pop_back();
    near.program.insert(near.program.end(),
                        {ApplyStep{"near", "sum", "twice"}, AddStep{"sum", "twice", "again"},
                         ReconstructStep{"again"}});
    validate(near, "near");
    expect_same_light(near, "near again, ");
  }
}

TEST(GlSamples, RefusesMoreLightsThanItHolds) {
  const gl::OffscreenContext context;
  const Package room = synthetic_room();
  gl::GlRenderer gl(room);
  EXPECT_NO_THROW(gl.set_lights(std::vector<Light>(gl::kMostLights)));
  EXPECT_THROW(gl.set_lights(std::vector<Light>(gl::kMostLights + 1)), UserError);
}

}  // namespace
}  // namespace prt
