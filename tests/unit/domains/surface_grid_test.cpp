#include "domains/surface_grid.h"

#include <gtest/gtest.h>

#include <thread>

#include "base/random.h"
#include "scene/scene.h"

namespace prt {
namespace {

constexpr float kSpacing = 0.1F;
constexpr std::size_t kPoints = 20000;

/// Two crossing walls and a slanted sliver, from one triangle each or a few, at an offset that
/// costs digits.
Scene walls(const Vec3f& offset) {
  Scene scene;
  const auto add = [&](const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const auto first = static_cast<std::uint32_t>(scene.positions.size());
    for (const Vec3f& p : {a, b, c}) scene.positions.push_back(p + offset);
    scene.triangles.push_back({{first, first + 1, first + 2}, 0, 0});
  };
  add({0, 0, 0}, {2, 0, 0}, {0, 1, 0});
  add({2, 1, 0}, {0, 1, 0}, {2, 0, 0});
  add({1, 0, -0.5F}, {1, 1, -0.5F}, {1, 0, 0.5F});
  add({0, 0, 0.2F}, {2, 0.01F, 0.3F}, {2, 0.03F, 0.3F});
  add({0.3F, 0.3F, 0.2F}, {0.31F, 0.3F, 0.2F}, {0.3F, 0.31F, 0.21F});
  return scene;
}

/// Samples strewn over both sides of all triangles, with normals that differ by up to 40°.
SampleSet strewn(const Scene& scene, std::size_t count) {
  SampleSet samples;
  for (std::size_t k = 0; k < count; ++k) {
    Random random(1, k);
    const auto t =
        static_cast<std::uint32_t>(random.uniform() * static_cast<float>(scene.triangles.size()));
    const float u = random.uniform();
    const float v = (1.0F - u) * random.uniform();
    const float side = random.uniform() < 0.5F ? -1.0F : 1.0F;
    Vec3f tilt(random.uniform(), random.uniform(), random.uniform());
    tilt = 0.8F * (tilt - Vec3f::Constant(0.5F));
    samples.positions.push_back(triangle_point(scene, t, u, v));
    samples.normals.push_back((side * triangle_normal(scene, t) + tilt).normalized());
  }
  return samples;
}

SurfacePoint random_point(const Scene& scene, std::size_t k) {
  Random random(2, k);
  SurfacePoint point;
  point.triangle =
      static_cast<std::uint32_t>(random.uniform() * static_cast<float>(scene.triangles.size()));
  // Corners and edges as often as not.
  point.u = std::clamp(1.5F * random.uniform() - 0.25F, 0.0F, 1.0F);
  point.v = (1.0F - point.u) * std::clamp(1.5F * random.uniform() - 0.25F, 0.0F, 1.0F);
  point.front = random.uniform() < 0.5F;
  point.position = triangle_point(scene, point.triangle, point.u, point.v);
  point.normal = (point.front ? 1.0F : -1.0F) * triangle_normal(scene, point.triangle);
  return point;
}

void expect_answers_of_the_grid(const Scene& scene, std::size_t count, float reach) {
  const SampleSet samples = strewn(scene, count);
  const SampleGrid grid(samples.positions, samples.normals, 3.0F * kSpacing);
  const SurfaceGrid surfaces(scene, samples, grid, reach, kSpacing);
  std::size_t known = 0;
  for (std::size_t k = 0; k < kPoints; ++k) {
    const SurfacePoint point = random_point(scene, k);
    for (const float radius : {0.4F * kSpacing, reach}) {
      const auto found = surfaces.nearest(point, radius);
      if (!found) continue;
      ++known;
      ASSERT_EQ(*found, grid.nearest(point.position, point.normal, radius)) << k;
    }
  }
  EXPECT_GT(known, kPoints / 2);  // the table was really asked
}

TEST(SurfaceGrid, AnswersAsTheGridDoes) {
  expect_answers_of_the_grid(walls(Vec3f::Zero()), 1500, 0.4F);
}

TEST(SurfaceGrid, AnswersAsTheGridDoesFarFromTheOrigin) {
  expect_answers_of_the_grid(walls({1000, -500, 3000}), 1500, 0.4F);
}

TEST(SurfaceGrid, KnowsNothingWhereThereAreNoSamples) {
  const Scene scene = walls(Vec3f::Zero());
  const SampleSet none;
  const SampleGrid grid({}, {}, kSpacing);
  const SurfaceGrid surfaces(scene, none, grid, 1.0F, kSpacing);
  SurfacePoint point;
  point.triangle = 0;
  EXPECT_FALSE(surfaces.nearest(point, 1.0F).has_value());
}

TEST(SurfaceGrid, StaysSmallOnWideTriangles) {
  Scene scene = walls(Vec3f::Zero());
  for (Vec3f& p : scene.positions) p *= 1e5F;
  const SampleSet samples = strewn(scene, 100);
  const SampleGrid grid(samples.positions, samples.normals, kSpacing);
  // 4e12 texels of this size would not fit into any memory.
  const SurfaceGrid surfaces(scene, samples, grid, 4.0F * kSpacing, kSpacing);
  SurfacePoint point;
  point.triangle = 0;
  point.position = scene.positions[0];
  point.normal = triangle_normal(scene, 0);
  const auto found = surfaces.nearest(point, kSpacing);
  EXPECT_TRUE(!found || *found == grid.nearest(point.position, point.normal, kSpacing));
}

TEST(SurfaceGrid, MakesListsWhereItIsAsked) {
  const Scene scene = walls(Vec3f::Zero());
  const SampleSet samples = strewn(scene, 1500);
  const SampleGrid grid(samples.positions, samples.normals, 3.0F * kSpacing);
  const SurfaceGrid surfaces(scene, samples, grid, 0.4F, 0.1F * kSpacing);
  EXPECT_EQ(surfaces.made_texels(), 0U);
  ASSERT_GT(surfaces.texels(), 10000U);
  SurfacePoint point;
  point.triangle = 1;
  point.u = point.v = 0.3F;
  point.position = triangle_point(scene, 1, point.u, point.v);
  point.normal = triangle_normal(scene, 1);
  point.front = true;
  surfaces.fetch_place(point);
  surfaces.fetch_list(point);
  (void)surfaces.nearest(point, 0.4F);
  EXPECT_GT(surfaces.made_texels(), 0U);
  EXPECT_LT(surfaces.made_texels(), 100U);
  for (std::size_t k = 0; k < kPoints; ++k) {
    (void)surfaces.nearest(random_point(scene, k), 0.4F);
  }
  EXPECT_GT(surfaces.made_texels(), surfaces.texels() / 2);
  EXPECT_LE(surfaces.made_texels(), surfaces.texels());
}

TEST(SurfaceGrid, AnswersSeveralThreadsAtOnceAlike) {
  const Scene scene = walls(Vec3f::Zero());
  const SampleSet samples = strewn(scene, 1500);
  const SampleGrid grid(samples.positions, samples.normals, 3.0F * kSpacing);
  for (int round = 0; round < 20; ++round) {
    const SurfaceGrid surfaces(scene, samples, grid, 0.4F, kSpacing);
    std::vector<std::vector<std::uint32_t>> found(4);
    std::vector<std::thread> threads;
    for (auto& mine : found) {
      threads.emplace_back([&] {
        for (std::size_t k = 0; k < 2000; ++k) {
          const SurfacePoint point = random_point(scene, k);
          mine.push_back(surfaces.nearest(point, 0.4F).value_or(kNone - 1));
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (std::size_t k = 0; k < 2000; ++k) {
      if (found[0][k] == kNone - 1) continue;
      const SurfacePoint point = random_point(scene, k);
      ASSERT_EQ(found[0][k], grid.nearest(point.position, point.normal, 0.4F));
    }
    for (const auto& other : found) ASSERT_EQ(other, found[0]);
  }
}

}  // namespace
}  // namespace prt
