#include "domains/splats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/random.h"
#include "domains/thinning.h"

namespace prt {
namespace {

/// Weights are sums of a few dozen floats.
constexpr float kSumTolerance = 1e-5F;

struct Sheet {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
};

/// A maximal Poisson-disk set of a square of the given side in the plane of origin, u and v.
Sheet poisson_square(const Vec3f& origin, const Vec3f& u, const Vec3f& v, float side, float radius,
                     std::uint64_t stream) {
  const auto count = static_cast<std::size_t>(200.0F * side * side / (radius * radius));
  Sheet candidates;
  std::vector<std::uint64_t> priorities;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(stream, i);
    candidates.positions.push_back(origin + side * random.uniform() * u +
                                   side * random.uniform() * v);
    candidates.normals.push_back(u.cross(v));
    priorities.push_back((std::uint64_t{random.bits()} << 32) | random.bits());
  }
  const std::vector<float> flat(count, 0.0F);
  Sheet sheet;
  for (const std::uint32_t i : thin({candidates.positions, candidates.normals, flat, priorities},
                                    radius, kCompatibleCosine)) {
    sheet.positions.push_back(candidates.positions[i]);
    sheet.normals.push_back(candidates.normals[i]);
  }
  return sheet;
}

void append(SampleSet& samples, const Sheet& sheet, float radius) {
  for (std::size_t i = 0; i < sheet.positions.size(); ++i) {
    samples.positions.push_back(sheet.positions[i]);
    samples.normals.push_back(sheet.normals[i]);
    samples.radii.push_back(radius);
  }
}

SampleSet floor_samples(float side, float radius) {
  SampleSet samples;
  append(samples, poisson_square(Vec3f::Zero(), Vec3f::UnitZ(), Vec3f::UnitX(), side, radius, 1),
         radius);
  return samples;
}

float sum_of(const std::vector<SplatWeight>& weights) {
  float sum = 0.0F;
  for (const SplatWeight& w : weights) sum += w.weight;
  return sum;
}

TEST(Splats, AreAPartitionOfUnityWhereverTheSurfaceIsSampled) {
  const SampleSet samples = floor_samples(10.0F, 0.5F);
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  for (std::uint64_t q = 0; q < 5000; ++q) {
    Random random(2, q);
    field.weights_at({10.0F * random.uniform(), 0.0F, 10.0F * random.uniform()}, Vec3f::UnitY(),
                     weights);
    ASSERT_GE(weights.size(), 2U);  // the kernels themselves, not the nearest sample in their stead
    ASSERT_NEAR(sum_of(weights), 1.0F, kSumTolerance);
    for (const SplatWeight& w : weights) ASSERT_GE(w.weight, 0.0F);
  }
}

TEST(Splats, InterpolateSmoothFunctions) {
  // Relative error of a sine of eight radii, measured 0.122 at the kernel's width of 0.6 radii
  // (0.20 at 0.3 and 0.13 at 1.0); of twenty radii 0.039.
  constexpr double kErrorAtEight = 0.135;
  constexpr double kErrorAtTwenty = 0.045;
  constexpr float kSide = 30.0F;
  const SampleSet samples = floor_samples(kSide, 1.0F);
  const SplatField field(samples);
  const auto error = [&](float wavelength) {
    const auto wave = [&](const Vec3f& p) {
      return std::sin(2.0F * kPi * (0.8F * p.x() + 0.6F * p.z()) / wavelength);
    };
    double squared = 0.0;
    double power = 0.0;
    std::vector<SplatWeight> weights;
    for (std::uint64_t q = 0; q < 4000; ++q) {
      Random random(3, q);
      const Vec3f p(4.0F + (kSide - 8.0F) * random.uniform(), 0.0F,
                    4.0F + (kSide - 8.0F) * random.uniform());
      field.weights_at(p, Vec3f::UnitY(), weights);
      double value = 0.0;
      for (const SplatWeight& w : weights) value += w.weight * wave(samples.positions[w.sample]);
      squared += (value - wave(p)) * (value - wave(p));
      power += wave(p) * wave(p);
    }
    return std::sqrt(squared / power);
  };
  EXPECT_LT(error(8.0F), kErrorAtEight);
  EXPECT_LT(error(20.0F), kErrorAtTwenty);
}

TEST(Splats, NothingPassesThroughAThinWall) {
  SampleSet samples;
  append(samples, poisson_square(Vec3f::Zero(), Vec3f::UnitX(), Vec3f::UnitY(), 4.0F, 0.3F, 4),
         0.3F);
  const auto front = static_cast<std::uint32_t>(samples.size());
  append(samples,
         poisson_square(Vec3f(0, 0, -0.01F), Vec3f::UnitY(), Vec3f::UnitX(), 4.0F, 0.3F, 5), 0.3F);
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  for (std::uint64_t q = 0; q < 1000; ++q) {
    Random random(6, q);
    const Vec3f p(4.0F * random.uniform(), 4.0F * random.uniform(), 0.0F);
    field.weights_at(p, Vec3f::UnitZ(), weights);
    ASSERT_FALSE(weights.empty());
    for (const SplatWeight& w : weights) ASSERT_LT(w.sample, front);
  }
}

TEST(Splats, AShelfHardlyTakesFromTheNextOne) {
  // Both face up, 0.5 radii apart: position alone tells them apart.
  constexpr float kLeak = 1e-4F;
  SampleSet samples = floor_samples(4.0F, 0.3F);
  const auto lower = static_cast<std::uint32_t>(samples.size());
  append(samples, poisson_square(Vec3f(0, 0.15F, 0), Vec3f::UnitZ(), Vec3f::UnitX(), 4.0F, 0.3F, 7),
         0.3F);
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  for (std::uint64_t q = 0; q < 1000; ++q) {
    Random random(8, q);
    field.weights_at({4.0F * random.uniform(), 0.0F, 4.0F * random.uniform()}, Vec3f::UnitY(),
                     weights);
    float leak = 0.0F;
    for (const SplatWeight& w : weights) leak += w.sample >= lower ? w.weight : 0.0F;
    ASSERT_LT(leak, kLeak);
  }
}

TEST(Splats, NothingPassesAroundARightAngle) {
  SampleSet samples = floor_samples(4.0F, 0.3F);
  const auto wall = static_cast<std::uint32_t>(samples.size());
  append(samples, poisson_square(Vec3f::Zero(), Vec3f::UnitX(), Vec3f::UnitY(), 4.0F, 0.3F, 9),
         0.3F);
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  field.weights_at({2.0F, 0.0F, 0.001F}, Vec3f::UnitY(), weights);
  ASSERT_FALSE(weights.empty());
  for (const SplatWeight& w : weights) EXPECT_LT(w.sample, wall);
}

TEST(Splats, CurvedSurfacesAreReachedEverywhere) {
  // A sphere of one metre with samples 0.3 m apart: neighbours lie far off each other's tangent
  // planes.
  SampleSet samples;
  std::vector<Vec3f> candidates;
  std::vector<std::uint64_t> priorities;
  for (std::uint64_t i = 0; i < 30000; ++i) {
    Random random(10, i);
    const float u = random.uniform();
    candidates.push_back(sphere_direction(u, random.uniform()));
    priorities.push_back((std::uint64_t{random.bits()} << 32) | random.bits());
  }
  const std::vector<float> flat(candidates.size(), 0.0F);
  for (const std::uint32_t i :
       thin({candidates, candidates, flat, priorities}, 0.3F, kCompatibleCosine)) {
    samples.positions.push_back(candidates[i]);
    samples.normals.push_back(candidates[i]);
    samples.radii.push_back(0.3F);
  }
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  for (std::uint64_t q = 0; q < 2000; ++q) {
    Random random(11, q);
    const float u = random.uniform();
    const Vec3f p = sphere_direction(u, random.uniform());
    field.weights_at(p, p, weights);
    ASSERT_GE(weights.size(), 2U);
    // The bisecting plane keeps the whole ring of neighbours in play: the largest weight is
    // moderate.
    float largest = 0.0F;
    for (const SplatWeight& w : weights) largest = std::max(largest, w.weight);
    ASSERT_LT(largest, 0.95F);
  }
}

TEST(Splats, FarFromEverySampleThereIsNothing) {
  const SampleSet samples = floor_samples(4.0F, 0.3F);
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  field.weights_at({2.0F, 3.0F, 2.0F}, Vec3f::UnitY(), weights);
  EXPECT_TRUE(weights.empty());
  field.weights_at({2.0F, 0.0F, 2.0F}, -Vec3f::UnitY(), weights);
  EXPECT_TRUE(weights.empty());
}

TEST(Splats, JustBeyondTheKernelsTheNearestSampleStandsIn) {
  SampleSet samples;
  samples.positions = {Vec3f::Zero()};
  samples.normals = {Vec3f::UnitY()};
  samples.radii = {1.0F};
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  field.weights_at({2.5F, 0.0F, 0.0F}, Vec3f::UnitY(), weights);
  ASSERT_EQ(weights.size(), 1U);
  EXPECT_EQ(weights[0].weight, 1.0F);
}

TEST(Splats, OneAbsurdRadiusDoesNotReachEverywhere) {
  SampleSet samples = floor_samples(10.0F, 0.5F);
  samples.radii[0] = 1000.0F;
  const SplatField field(samples);
  std::vector<SplatWeight> weights;
  const Vec3f far = samples.positions[0].x() < 5.0F ? Vec3f(9, 0, 9) : Vec3f(1, 0, 1);
  field.weights_at(far, Vec3f::UnitY(), weights);
  EXPECT_LT(weights.size(), 100U);
  EXPECT_NEAR(sum_of(weights), 1.0F, kSumTolerance);
}

}  // namespace
}  // namespace prt
