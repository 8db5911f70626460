#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "evaluate/reference.h"
#include "methods/sh/plan.h"
#include "player/environment_light.h"
#include "player/evaluator.h"
#include "sky_scenes.h"
#include "statistical/closed_forms.h"

namespace prt {
namespace {

using test::InProcessBake;
using test::sky_options;

// Coefficients in float.
constexpr double kRounding = 1e-5;
constexpr int kOrder = 5;

struct Baked {
  Baked(const Scene& scene, const OptionValues& options) : bake(scene, options) {
    plan = bake.run(sh_method());
    package = sh_method().assemble([&](const std::string& id) { return bake.result(id); },
                                   bake.options());
    package.scene = scene;
  }
  [[nodiscard]] MatrixF direct() const {
    MatrixF all(static_cast<Eigen::Index>(package.samples.size()), sh_count(kOrder));
    for (std::uint32_t c = 0; c < package.samples.clusters(); ++c) {
      all.middleRows(package.samples.cluster_begin[c], package.samples.cluster_size(c)) =
          bake.result(numbered(sh::kDirect, c))->matrix("transfer");
    }
    return all;
  }
  [[nodiscard]] std::size_t tasks(const std::string& kind) const {
    return static_cast<std::size_t>(std::ranges::count(plan.tasks, kind, &TaskSpec::kind));
  }
  [[nodiscard]] std::string left_out() const {
    std::string all;
    for (const LeftOut& what : plan.left_out) all += what.what + ": " + what.reason + "; ";
    return all;
  }
  InProcessBake bake;
  Plan plan;
  Package package;
};

/// The closed form at every sample.
MatrixF open_transfer(const SampleSet& samples) {
  MatrixF all(static_cast<Eigen::Index>(samples.size()), sh_count(kOrder));
  for (std::size_t s = 0; s < samples.size(); ++s) {
    all.row(static_cast<Eigen::Index>(s)) =
        lambert_sh(kOrder, samples.normals[s].cast<double>()).transpose().cast<float>();
  }
  return all;
}

TEST(SkyTransfer, WithoutShadowsIsTheClosedFormAndCastsNoRay) {
  OptionValues options = sky_options(sh_method(), 300, {1, 1, 1});
  options.set("sh.transfer", "unshadowed");
  const Baked baked(test::open_box(Vec3f::Constant(0.5F)), options);
  EXPECT_LT((baked.direct() - open_transfer(baked.package.samples)).cwiseAbs().maxCoeff(),
            kRounding);
  EXPECT_EQ(baked.tasks("rays"), 0U);
  EXPECT_EQ(baked.tasks(sh::kBounce), 0U);
}

TEST(SkyTransfer, OfAConvexObjectIsThatWithoutShadows) {
  const Baked baked(test::ball(Vec3f::Constant(0.5F)), sky_options(sh_method(), 500, {0, 0, 3}));
  EXPECT_LT((baked.direct() - open_transfer(baked.package.samples)).cwiseAbs().maxCoeff(),
            kRounding);
}

TEST(SkyTransfer, OfAConstantSkyIntoABoxIsItsViewFactor) {
  OptionValues options = sky_options(sh_method(), 600, {1, 1, 1});
  options.set("transport.bounces", 0);
  options.set("compression.tolerance", 1e-4);
  options.set("compression.bits", 16);
  const Baked baked(test::open_box(Vec3f::Constant(0.5F)), options);
  const Evaluator player(baked.package);
  const EnvironmentLight sky(Environment(2, 1, std::vector<Vec3f>(2, Vec3f(1, 2, 3))), kOrder);
  const SampleIrradiance played = player.evaluate({}, sky.coefficients());
  // A direction stands for at most π/504 W/m², and the lid's edges run through some 40 of their
  // cells, in parts along them: up to a fifth of those may be counted wrongly, in the mean few.
  constexpr double kEdge = 0.2 * 40.0 * test::kPiD / 504.0;
  constexpr double kMeanEdge = 0.01;
  std::size_t floor = 0;
  double sum = 0.0, expected_sum = 0.0;
  for (std::size_t s = 0; s < baked.package.samples.size(); ++s) {
    const Vec3f& p = baked.package.samples.positions[s];
    const Vec3f& n = baked.package.samples.normals[s];
    if (n.y() < 0.9F || p.y() > 0.1F) continue;
    ++floor;
    const std::vector<Vec3d> lid = {{0.0 - p.x(), 2.0, 0.0 - p.z()},
                                    {0.0 - p.x(), 2.0, 2.0 - p.z()},
                                    {2.0 - p.x(), 2.0, 2.0 - p.z()},
                                    {2.0 - p.x(), 2.0, 0.0 - p.z()}};
    const double expected = std::abs(test::lambert_polygon(lid, Vec3d::UnitY()));
    const auto row = static_cast<Eigen::Index>(s);
    EXPECT_NEAR(played.sky(row, 0), expected, kEdge);
    EXPECT_NEAR(played.sky(row, 2), 3.0F * played.sky(row, 0), 1e-4F);
    sum += played.sky(row, 0);
    expected_sum += expected;
  }
  EXPECT_GT(floor, 50U);
  EXPECT_NEAR(sum, expected_sum, kMeanEdge * expected_sum);
  EXPECT_EQ(played.indirect.norm(), 0.0F);
}

TEST(SkyTransfer, BetweenTheSidesOfABoxAgreesWithThePathTracer) {
  const Scene scene = test::open_box(Vec3f(0.7F, 0.5F, 0.2F));
  OptionValues options = sky_options(sh_method(), 2500, {1, 1, 1});
  options.set("transport.tolerance", 1e-3);
  options.set("compression.tolerance", 1e-3);
  options.set("compression.bits", 16);
  const Baked baked(scene, options);
  const Environment environment = test::two_bands(Vec3f(1.0F, 0.9F, 0.8F));
  const SampleIrradiance played =
      Evaluator(baked.package).evaluate({}, EnvironmentLight(environment, kOrder).coefficients());
  const SampleSet& samples = baked.package.samples;
  std::vector<ReceiverPoint> points;
  std::vector<std::size_t> chosen;
  for (std::size_t s = 0; s < samples.size(); s += 5) {
    points.push_back({samples.positions[s], samples.normals[s]});
    chosen.push_back(s);
  }
  const auto traced = trace_irradiance(scene, baked.bake.caster(), {}, points,
                                       {.paths = 256, .environment = &environment}, 7);
  for (const bool indirect : {false, true}) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      double difference = 0.0, noise = 0.0, mean = 0.0;
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        const auto& halves = indirect ? traced[i].indirect : traced[i].direct;
        const MatrixF& values = indirect ? played.indirect : played.sky;
        const auto row = static_cast<Eigen::Index>(chosen[i]);
        difference += values(row, c) - 0.5 * (halves[0][c] + halves[1][c]);
        noise += 0.25 * std::pow(halves[0][c] - halves[1][c], 2);
        mean += values(row, c);
      }
      // Three standard errors of the reference, below one part in a hundred.
      EXPECT_LT(std::abs(difference), 3.0 * std::sqrt(noise)) << indirect << c << " of " << mean;
      EXPECT_LT(std::sqrt(noise), 0.01 * mean);
      EXPECT_GT(mean, 0.0);
    }
  }
}

TEST(SkyTransfer, OfAStatedNumberOfBouncesStopsThere) {
  const Scene scene = test::open_box(Vec3f::Constant(0.8F));
  double before = 0.0;
  for (const int bounces : {1, 2, 4}) {
    OptionValues options = sky_options(sh_method(), 300, {1, 1, 1});
    options.set("transport.bounces", bounces);
    const Baked baked(scene, options);
    EXPECT_EQ(baked.tasks(sh::kBounce),
              static_cast<std::size_t>(bounces) * baked.package.samples.clusters());
    const EnvironmentLight sky(Environment(2, 1, std::vector<Vec3f>(2, Vec3f::Ones())), kOrder);
    const double sum = Evaluator(baked.package).evaluate({}, sky.coefficients()).indirect.sum();
    EXPECT_GT(sum, before);
    before = sum;
  }
}

TEST(SkyTransfer, StopsBouncingWhereTheRestIsBelowTheTolerance) {
  OptionValues options = sky_options(sh_method(), 300, {1, 1, 1});
  options.set("transport.tolerance", 0.1);
  const Baked coarse(test::open_box(Vec3f::Constant(0.8F)), options);
  options.set("transport.tolerance", 1e-4);
  const Baked fine(test::open_box(Vec3f::Constant(0.8F)), options);
  EXPECT_LT(coarse.tasks(sh::kBounce), fine.tasks(sh::kBounce));
  const EnvironmentLight sky(Environment(2, 1, std::vector<Vec3f>(2, Vec3f::Ones())), kOrder);
  const auto indirect = [&](const Baked& baked) {
    return Evaluator(baked.package).evaluate({}, sky.coefficients()).indirect.sum();
  };
  EXPECT_LT(indirect(coarse), indirect(fine));
  EXPECT_GT(indirect(coarse), 0.85 * indirect(fine));
  EXPECT_NE(coarse.left_out().find("bounces"), std::string::npos) << coarse.left_out();
}

TEST(SkyTransfer, OfBlackAndGreySurfacesIsLess) {
  const OptionValues options = sky_options(sh_method(), 300, {1, 1, 1});
  const Baked black(test::open_box(Vec3f::Zero()), options);
  EXPECT_EQ(black.tasks(sh::kBounce), 0U);
  EXPECT_NE(black.left_out().find("black"), std::string::npos) << black.left_out();
  const auto channels = [](const Baked& baked) {
    return std::get<ClusterTransfer>(baked.package.operators.at("sky_bounced")).channels;
  };
  EXPECT_EQ(channels(Baked(test::open_box(Vec3f::Constant(0.5F)), options)), 1U);
  EXPECT_EQ(channels(Baked(test::open_box(Vec3f(0.5F, 0.4F, 0.3F)), options)), 3U);
}

TEST(SkyTransfer, IntoAClosedSceneIsLeftOut) {
  Scene scene;
  test::add_box(scene, Vec3f::Zero(), Vec3f::Ones(),
                test::add_material(scene, Vec3f::Constant(0.5F)));
  test::finish(scene);
  const Baked baked(scene, sky_options(sh_method(), 200, {0.5, 0.5, 0.5}));
  EXPECT_TRUE(baked.plan.complete);
  EXPECT_FALSE(baked.plan.plays_environment);
  EXPECT_TRUE(baked.package.program.empty());
  EXPECT_NE(baked.left_out().find("environment layer: no cluster sees"), std::string::npos)
      << baked.left_out();
}

TEST(SkyTransfer, IsWindowedBandByBand) {
  OptionValues options = sky_options(sh_method(), 300, {0, 0, 3});
  options.set("compression.bits", 32);
  options.set("compression.tolerance", 1e-6);
  const Scene scene = test::ball(Vec3f::Zero());
  const Baked plain(scene, options);
  options.set("sh.window", 4.0);
  const Baked windowed(scene, options);
  const std::vector<double> bands = hann_bands(kOrder, 4.0);
  for (int l = 0; l < kOrder; ++l) {
    MatrixF one = MatrixF::Zero(3, sh_count(kOrder));
    one.col(sh_index(l, 0)).setOnes();
    const MatrixF expected = static_cast<float>(bands[static_cast<std::size_t>(l)]) *
                             Evaluator(plain.package).evaluate({}, one).sky;
    const MatrixF value = Evaluator(windowed.package).evaluate({}, one).sky;
    EXPECT_LT((value - expected).cwiseAbs().maxCoeff(), 1e-4F) << l;
  }
}

}  // namespace
}  // namespace prt
