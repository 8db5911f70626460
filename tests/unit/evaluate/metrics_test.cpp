#include "evaluate/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"

namespace prt {
namespace {

/// Float sums of a few terms against the same by hand.
constexpr double kRounding = 1e-6;

Vec3f grey(float v) { return Vec3f::Constant(v); }

TEST(Metrics, SumsByHand) {
  const std::vector<Vec3f> values = {grey(3), Vec3f(-1, 2, 2)};
  const std::vector<Vec3f> first = {grey(1), grey(2)}, second = {grey(2), grey(4)};
  const std::vector<float> weights = {0.25F, 0.75F};
  const IrradianceSums sums = irradiance_sums(values, first, second, weights);
  // (3-1)(3-2)·3·¼ + [(-1-2)(-1-4) + 0 + 0]·¾
  EXPECT_NEAR(sums.squared_error, 1.5 + 11.25, kRounding);
  EXPECT_NEAR(sums.squared_power, 0.25 * 6 + 0.75 * 24, kRounding);
  EXPECT_NEAR(sums.negative, 0.75 / 3, kRounding);
  // Point 1: h = -½, m = 3/2, r̄ = 3/2; point 2: h = -1, m = (-4, -1, -1), r̄ = 3.
  const double hm1 = 2 * 0.25 * -0.5 * 1.5 * 3, hm2 = 2 * 0.75 * 6;
  const double hr1 = 2 * 0.25 * -0.5 * 1.5 * 3, hr2 = 2 * 0.75 * -9;
  EXPECT_NEAR(sums.noise_mm, hm1 * hm1 + hm2 * hm2, kRounding * 100);
  EXPECT_NEAR(sums.noise_mr, hm1 * hr1 + hm2 * hr2, kRounding * 100);
  EXPECT_NEAR(sums.noise_rr, hr1 * hr1 + hr2 * hr2, kRounding * 100);
}

TEST(Metrics, PoolsOverLightsAndKeepsThemApart) {
  std::vector<IrradianceSums> lights(3);
  lights[0].squared_error = 0.01, lights[0].squared_power = 1.0;   // 10 %
  lights[1].squared_error = 0.04, lights[1].squared_power = 1.0;   // 20 %
  lights[2].squared_error = 9.0, lights[2].squared_power = 100.0;  // 30 %
  const IrradianceError error = irradiance_error(lights);
  EXPECT_NEAR(error.rel_rmse, std::sqrt(9.05 / 102.0), kRounding);
  EXPECT_NEAR(error.rel_rmse_median, 0.2, kRounding);
  EXPECT_NEAR(error.rel_rmse_p95, 0.29, kRounding);
  EXPECT_GT(error.light_error, 0.0);
  EXPECT_EQ(error.standard_error, 0.0);
}

TEST(Metrics, DarkLights) {
  std::vector<IrradianceSums> lights(1);
  EXPECT_EQ(irradiance_error(lights).rel_rmse, 0.0);
  lights[0].squared_error = 1.0;
  EXPECT_TRUE(std::isinf(irradiance_error(lights).rel_rmse));
  EXPECT_TRUE(to_json(irradiance_error(lights))["rel_rmse"].is_null());
}

TEST(Metrics, CountsWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vec3f> good = {grey(1), grey(1)}, bad = {grey(1), Vec3f(1, nan, 1)};
  const std::vector<float> weights = {0.5F, 0.5F};
  EXPECT_EQ(irradiance_sums(bad, good, good, weights).not_finite, 1U);
  EXPECT_EQ(irradiance_sums(good, bad, good, weights).not_finite, 1U);
  EXPECT_EQ(irradiance_sums(good, good, bad, weights).not_finite, 1U);
}

float normal(Random& random) {
  return std::sqrt(-2.0F * std::log(1.0F - random.uniform())) *
         std::cos(2.0F * kPi * random.uniform());
}

// Noisy references of the truth 1 judge a value that is 10 % off. The squared error has no bias
// from the noise, and the standard error is the spread of the estimate over seeds.
TEST(Metrics, NoiseLeavesNoBiasAndIsToldHonestly) {
  constexpr int kTrials = 2000;
  constexpr std::size_t kPoints = 200;
  constexpr float kNoise = 0.5F;
  constexpr double kTrueError = 0.1;
  // Relative spread of a standard deviation from 2000 trials is 1.6 %; four of those, and 3 % for
  // the linearisation.
  constexpr double kSpreadTolerance = 0.1;
  const std::vector<Vec3f> values(kPoints, grey(1.0F + static_cast<float>(kTrueError)));
  const std::vector<float> weights(kPoints, 1.0F / kPoints);
  double mean = 0.0, squares = 0.0, told = 0.0, rms = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<IrradianceSums> lights;
    for (std::uint64_t light = 0; light < 4; ++light) {
      Random random(17, 4 * static_cast<std::uint64_t>(trial) + light);
      std::vector<Vec3f> r1, r2;
      for (std::size_t i = 0; i < kPoints; ++i) {
        r1.push_back(grey(1.0F + kNoise * normal(random)));
        r2.push_back(grey(1.0F + kNoise * normal(random)));
      }
      lights.push_back(irradiance_sums(values, r1, r2, weights));
    }
    double error = 0.0, power = 0.0;
    for (const auto& s : lights) error += s.squared_error, power += s.squared_power;
    const double x = error / power;
    mean += x / kTrials;
    squares += x * x / kTrials;
    const IrradianceError figures = irradiance_error(lights);
    // Undo the square root: the standard error of x.
    const double sigma = figures.standard_error * 2.0 * figures.rel_rmse;
    told += sigma * sigma / kTrials;
    rms += figures.rel_rmse / kTrials;
  }
  const double spread = std::sqrt(squares - mean * mean);
  const double four_standard_errors = 4.0 * spread / std::sqrt(kTrials);
  EXPECT_NEAR(mean, kTrueError * kTrueError, four_standard_errors);
  EXPECT_NEAR(std::sqrt(told) / spread, 1.0, 2.0 * kSpreadTolerance);
  EXPECT_NEAR(rms, kTrueError, 0.3 * kTrueError);
}

TEST(Metrics, VisibilityByHand) {
  const Vec3f up = Vec3f::UnitY();
  // The light is 1 m above the first two points, 2 m above the third, and behind the last.
  const std::vector<ReceiverPoint> points = {
      {Vec3f(0, 1, 0), up}, {Vec3f(0, 1, 0), up}, {Vec3f(0, 0, 0), up}, {Vec3f(0, 5, 0), up}};
  const std::vector<float> weights = {0.1F, 0.2F, 0.3F, 0.4F};
  const std::vector<float> visibility = {0.75F, 0.5F, 0.25F, 1.0F};
  const std::vector<std::uint8_t> traced = {1, 0, 0, 0};
  const VisibilitySums sums = visibility_sums(points, weights, Vec3f(0, 2, 0), visibility, traced);
  const VisibilityError error = visibility_error({&sums, 1});
  EXPECT_NEAR(error.wrong_share, 0.2 / 0.6, kRounding);  // ½ counts as seen
  EXPECT_NEAR(error.soft, (0.1 * 0.25 + 0.2 * 0.5 + 0.3 * 0.25) / 0.6, kRounding);
  EXPECT_NEAR(error.weighted, (0.1 * 0.25 + 0.2 * 0.5 + 0.3 * 0.25 / 4) / (0.1 + 0.2 + 0.3 / 4),
              kRounding);
}

TEST(Metrics, Quantiles) {
  EXPECT_EQ(quantile({}, 0.5), 0.0);
  EXPECT_EQ(quantile({3.0}, 0.95), 3.0);
  EXPECT_NEAR(quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5, kRounding);
  EXPECT_EQ(quantile({1.0, 2.0, std::numeric_limits<double>::infinity()}, 0.5), 2.0);
}

}  // namespace
}  // namespace prt
