// Packages under an environment, on the CPU.
#include "player/environment_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "player/evaluator.h"
#include "player/picture.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

using test::synthetic_room;

// Sums of a few floats in another order; coefficients of integers of 16 bits.
constexpr float kRounding = 1e-5F;
constexpr float kSixteenBits = 1e-4F;
// The midpoint rule over cells of 0.7 degrees.
constexpr double kCells = 2e-4;
constexpr int kOrder = 4;

Environment coloured_sky() {
  std::vector<Vec3f> radiance;
  const Environment grid(64, 32, std::vector<Vec3f>(64UL * 32, Vec3f::Zero()));
  grid.visit(32, [&](const Vec3d& d, double, const Vec3f&) {
    const Vec3f way = d.cast<float>();
    radiance.emplace_back(1.0F + way.x(), 1.0F + 0.5F * way.y() * way.z(), 2.0F + way.z());
  });
  return {64, 32, std::move(radiance)};
}

TEST(EnvironmentLight, OfAConstantSkyHasOneCoefficient) {
  const Environment sky(2, 1, std::vector<Vec3f>(2, Vec3f(1, 2, 3)));
  const MatrixF c = EnvironmentLight(sky, kOrder).coefficients();
  ASSERT_EQ(c.rows(), 3);
  ASSERT_EQ(c.cols(), 16);
  EXPECT_NEAR(c(1, 0), 2.0 * std::sqrt(4.0 * static_cast<double>(kPi)), kCells);
  EXPECT_LT(c.rightCols(15).cwiseAbs().maxCoeff(), kCells);
}

TEST(EnvironmentLight, TurnsAsTheEnvironmentDoes) {
  const Environment sky = coloured_sky();
  for (const double degrees : {30.0, -115.0, 400.0}) {
    const MatrixF turned = EnvironmentLight(sky, kOrder).coefficients(degrees);
    const MatrixF projected = EnvironmentLight(sky.turned(degrees), kOrder).coefficients();
    EXPECT_LT((turned - projected).cwiseAbs().maxCoeff(), kCells) << degrees;
    EXPECT_GT((turned - EnvironmentLight(sky, kOrder).coefficients()).norm(), 0.1F);
  }
}

class EnvironmentPlay : public testing::Test {
 protected:
  static Package room(std::uint32_t channels, bool reflected) {
    Package package = synthetic_room({.albedo = {0.2F, 0.5F, 0.8F}});
    test::add_environment(package, kOrder, channels, reflected);
    validate(package, "room");
    return package;
  }
  MatrixF sky_ = EnvironmentLight(coloured_sky(), kOrder).coefficients();
};

TEST_F(EnvironmentPlay, IsTransferTimesCoefficients) {
  for (const std::uint32_t channels : {1U, 3U}) {
    const Package package = room(channels, false);
    const SampleIrradiance played = Evaluator(package).evaluate({}, sky_);
    EXPECT_EQ(played.direct.norm(), 0.0F);
    const SampleSet& samples = package.samples;
    for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
      const auto first = static_cast<Eigen::Index>(samples.cluster_begin[c]);
      const VectorF transfer =
          lambert_sh(kOrder, samples.normals[samples.cluster_begin[c]].cast<double>())
              .cast<float>();
      const Vec3f direct = sky_ * transfer;
      const Vec3f share = channels == 3 ? Vec3f(0.1F, 0.2F, 0.5F) : Vec3f::Constant(0.2F);
      EXPECT_TRUE(played.sky.row(first).transpose().isApprox(direct, kRounding)) << c;
      EXPECT_TRUE(
          played.indirect.row(first).transpose().isApprox(share.cwiseProduct(direct), kSixteenBits))
          << c;
    }
  }
}

TEST_F(EnvironmentPlay, AddsToLightsAndIsReflectedWhereTheProgramSaysSo) {
  Light light;
  light.position = Vec3f(1.5F, 2.0F, 2.5F);
  const std::span<const Light> lights(&light, 1);
  for (const bool reflected : {false, true}) {
    const Package package = room(3, reflected);
    const Evaluator player(package);
    const SampleIrradiance both = player.evaluate(lights, sky_);
    const SampleIrradiance by_light = player.evaluate(lights);
    const SampleIrradiance by_sky = player.evaluate({}, sky_);
    EXPECT_TRUE(both.direct.isApprox(by_light.direct, kRounding));
    EXPECT_TRUE(both.sky.isApprox(by_sky.sky, kRounding));
    EXPECT_TRUE(both.indirect.isApprox(by_light.indirect + by_sky.indirect, kRounding));
    EXPECT_EQ(by_light.sky.norm(), 0.0F);
    // What the room makes of direct light it makes of the sky's, too.
    const MatrixF more = by_sky.indirect - Evaluator(room(3, false)).evaluate({}, sky_).indirect;
    const MatrixF expected = reflected ? player.respond(by_sky.sky) : MatrixF::Zero(more.rows(), 3);
    EXPECT_LT((more - expected).norm(), kSixteenBits * by_sky.indirect.norm()) << reflected;
    EXPECT_EQ(more.norm() > 0.1F * by_sky.indirect.norm(), reflected);
  }
}

TEST_F(EnvironmentPlay, KeepsWhatStandsStillAndNothingElse) {
  std::vector<Light> lights(1);
  lights[0].position = Vec3f(1.5F, 2.0F, 2.5F);
  const auto same = [](const SampleIrradiance& a, const SampleIrradiance& b) {
    return a.direct == b.direct && a.sky == b.sky && a.indirect == b.indirect;
  };
  for (const bool reflected : {false, true}) {
    const Package package = room(3, reflected);
    const Evaluator player(package);
    SampleIrradiance kept;
    player.evaluate(lights, sky_, kept);
    const MatrixF turned = EnvironmentLight(coloured_sky(), kOrder).coefficients(90.0);
    player.evaluate(lights, turned, kept);
    EXPECT_TRUE(same(kept, player.evaluate(lights, turned)));
    EXPECT_FALSE(same(kept, player.evaluate(lights, sky_)));
    player.evaluate(lights, {}, kept);
    EXPECT_TRUE(same(kept, player.evaluate(lights)));
    lights[0].intensity.x() += 1.0F;
    player.evaluate(lights, {}, kept);
    EXPECT_TRUE(same(kept, player.evaluate(lights)));
    // Its own list of lights, changed in place.
    kept.lights[0].position.y() -= 0.5F;
    player.evaluate(kept.lights, sky_, kept);
    EXPECT_TRUE(same(kept, player.evaluate(kept.lights, sky_)));
    // Another evaluator's result.
    const Package other = synthetic_room();
    const Evaluator stranger(other);
    const std::vector<Light> moved = kept.lights;
    stranger.evaluate(moved, {}, kept);
    EXPECT_EQ(kept.sky.size(), 0);
    player.evaluate(moved, sky_, kept);
    EXPECT_TRUE(same(kept, player.evaluate(moved, sky_)));
  }
}

TEST_F(EnvironmentPlay, OfAnotherOrderIsRefused) {
  const Package package = room(3, false);
  const Evaluator player(package);
  EXPECT_THROW(static_cast<void>(player.evaluate({}, MatrixF::Zero(3, 9))), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(player.evaluate({}, MatrixF::Zero(16, 3))), std::invalid_argument);
  const Package without = synthetic_room();
  EXPECT_NO_THROW(static_cast<void>(Evaluator(without).evaluate({}, MatrixF::Zero(3, 9))));
}

TEST_F(EnvironmentPlay, ReachesPointsAsDirectLight) {
  const Package package = room(3, false);
  const Evaluator player(package);
  const SampleIrradiance played = player.evaluate({}, sky_);
  const Vec3f normal = package.samples.normals[0];
  const std::vector<PlayPoint> points = {{package.samples.positions[0], normal, normal}};
  const auto at = player.reconstruct(played, points);
  ASSERT_TRUE(at[0].reached);
  const Vec3f expected = sky_ * lambert_sh(kOrder, normal.cast<double>()).cast<float>();
  EXPECT_TRUE(at[0].direct.isApprox(expected, kSixteenBits));
}

TEST_F(EnvironmentPlay, WithoutALightStepTakesNoLight) {
  Package package = room(3, false);
  package.program = {EnvironmentLightStep{"sky", "sky light", "sky"}, ReconstructStep{"sky"}};
  package.visibility.reset();
  validate(package, "sky alone");
  EXPECT_FALSE(has_direct_light(package));
  const Evaluator player(package);
  const Light light;
  const SampleIrradiance played = player.evaluate({&light, 1}, sky_);
  EXPECT_EQ(played.direct.norm(), 0.0F);
  EXPECT_EQ(played.indirect.norm(), 0.0F);
  EXPECT_GT(played.sky.norm(), 0.0F);
  EXPECT_EQ(played.visibility[0][0], kUnlit);
}

TEST_F(EnvironmentPlay, IsBehindAllSurfacesAndMirroredInThem) {
  const Package package = room(3, false);
  const Evaluator player(package);
  const Environment sky = coloured_sky();
  const SampleIrradiance played = player.evaluate({}, sky_);
  PictureSettings settings{.width = 40, .height = 30, .environment = &sky, .linear = true};
  // From outside, the room small in the middle: a corner shows the sky.
  const SceneCamera camera{.eye = {2, 1.5F, 30}, .target = {2, 1.5F, 0}, .vertical_fov = 0.8F};
  const auto corner = [&](const Picture& picture) {
    return Vec3f(picture.radiance[0], picture.radiance[1], picture.radiance[2]);
  };
  const Vec3f view = view_direction(camera, 40, 30, 0.5F, 0.5F);
  EXPECT_EQ(corner(render(player, played, camera, settings)), sky.radiance(view));
  settings.environment = nullptr;
  EXPECT_EQ(corner(render(player, played, camera, settings)), Vec3f(Vec3f::Zero()));
  // Inside: looking straight at a wall, what is behind the camera is mirrored.
  const SceneCamera inside{.eye = {2, 1.5F, 1.0F}, .target = {2, 1.5F, 0}, .vertical_fov = 0.2F};
  settings.environment = &sky;
  const auto middle = [&] {
    const Picture picture = render(player, played, inside, settings);
    const std::size_t at = 3 * (15 * 40 + 20);
    return Vec3f(picture.radiance[at], picture.radiance[at + 1], picture.radiance[at + 2]);
  };
  const Vec3f plain = middle();
  settings.reflection = 0.25F;
  const Vec3f mirrored = middle() - plain;
  EXPECT_TRUE(mirrored.isApprox(0.25F * sky.radiance(Vec3f::UnitZ()), 0.1F))
      << mirrored.transpose();
}

}  // namespace
}  // namespace prt
