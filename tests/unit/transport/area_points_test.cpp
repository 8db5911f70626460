#include "transport/area_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "methods/lb/lb.h"
#include "scene/embree/embree_ray_caster.h"
#include "statistical/test_scenes.h"
#include "support/partial_bake.h"

namespace prt {
namespace {

constexpr std::uint64_t kTotal = 20000;

struct Drawn {
  Scene scene;
  AreaPointSettings settings;
  SurfacePoints reached;
  SurfacePoints points;
};

/// The points of a scene, after 1,000 particles' collisions.
Drawn draw(Scene scene, const Vec3f& start) {
  Drawn d;
  test::finish(scene);
  d.scene = std::move(scene);
  const auto caster = make_embree_ray_caster(d.scene);
  ParticleSettings particles;
  particles.start = start;
  d.settings.starts = {start};
  particles.wanted = 1000;
  particles.ray_budget = 40000;
  particles.stream = 1;
  d.reached = trace_particles(d.scene, *caster, particles);
  d.settings.total = kTotal;
  d.settings.stream = 2;
  d.points = draw_area_points(d.scene, *caster, d.reached, d.settings);
  return d;
}

std::uint32_t grey(Scene& scene) { return test::add_material(scene, Vec3f::Constant(0.5F)); }

/// A room of 2 m with a cube on its floor.
Scene room_with_cube() {
  Scene scene;
  const auto material = grey(scene);
  test::add_box(scene, Vec3f::Constant(-1.0F), Vec3f::Constant(1.0F), material);
  test::add_box(scene, {-0.4F, -1.0F, -0.4F}, {0.4F, -0.2F, 0.4F}, material);
  return scene;
}

TEST(AreaPoints, FillARoomAndNothingElse) {
  const Drawn d = draw(room_with_cube(), {0.7F, 0.5F, 0.6F});
  for (std::size_t i = 0; i < d.points.size(); ++i) {
    const Vec3f& p = d.points.positions[i];
    const Vec3f step = p + 1e-3F * d.points.normals[i];
    ASSERT_LT(step.cwiseAbs().maxCoeff(), 1.0F) << p.transpose();  // not outside
    const bool in_cube = std::abs(step.x()) < 0.4F && std::abs(step.z()) < 0.4F && step.y() < -0.2F;
    ASSERT_FALSE(in_cube) << p.transpose();
  }
  // One side of 24 + 5 · 0.64 - 0.64 of 24 + 6 · 0.64 m². Hardly a place of the room is not seen
  // from somewhere: the few that are missed lie low beside the cube.
  const double expected = static_cast<double>(kTotal) * (24.0 + 4 * 0.64) / (24.0 + 6 * 0.64);
  EXPECT_NEAR(static_cast<double>(d.points.size()) / expected, 1.0, 0.01);
}

/// A field 200 m wide with a hut, and a wall from behind which the start is not seen.
Scene field() {
  Scene scene;
  const auto material = grey(scene);
  test::add_quad(scene, {-100, 0, -100}, {0, 0, 200}, {200, 0, 0}, material);
  test::add_box(scene, {2, 3, 2}, {-2, 0, -2}, material);
  test::add_quad(scene, {10, 0, -40}, {0, 0, 80}, {0, 4, 0}, material);
  return scene;
}
const Vec3f kBesideTheHut(3.0F, 1.5F, 3.0F);

TEST(AreaPoints, CoverOpenGroundOnItsUpperSide) {
  const Drawn d = draw(field(), kBesideTheHut);
  constexpr int kCells = 20;
  std::vector<int> count(kCells * kCells, 0);
  for (std::size_t i = 0; i < d.points.size(); ++i) {
    const Vec3f& p = d.points.positions[i];
    if (p.y() > 0.0F) continue;
    ASSERT_GT(d.points.normals[i].y(), 0.0F) << p.transpose();
    const int x = static_cast<int>((p.x() + 100.0F) / (200.0F / kCells));
    const int z = static_cast<int>((p.z() + 100.0F) / (200.0F / kCells));
    ++count[std::min(x, kCells - 1) * kCells + std::min(z, kCells - 1)];
  }
  // 50 points fall into each cell; those low behind the wall see few places, but a fifth of them is
  // enough for a Poisson-disk set without holes.
  for (int c = 0; c < kCells * kCells; ++c) EXPECT_GT(count[c], 10) << c / kCells << ' ' << c % 20;
}

TEST(AreaPoints, OfTasksThatTakeTurnsAreTheWhole) {
  const Drawn d = draw(room_with_cube(), {0.7F, 0.5F, 0.6F});
  const auto caster = make_embree_ray_caster(d.scene);
  const auto sorted = [](const SurfacePoints& points) {
    std::vector<std::array<float, 3>> list;
    for (const Vec3f& p : points.positions) list.push_back({p.x(), p.y(), p.z()});
    std::sort(list.begin(), list.end());
    return list;
  };
  SurfacePoints parts;
  for (std::uint64_t first = 0; first < 3; ++first) {
    AreaPointSettings part = d.settings;
    part.first = first;
    part.step = 3;
    parts.append(draw_area_points(d.scene, *caster, d.reached, part));
  }
  EXPECT_EQ(sorted(parts), sorted(d.points));
}

TEST(AreaPoints, AreNoneWhereNothingWasReached) {
  const Drawn d = draw(room_with_cube(), {0.7F, 0.5F, 0.6F});
  const auto caster = make_embree_ray_caster(d.scene);
  EXPECT_EQ(draw_area_points(d.scene, *caster, SurfacePoints{}, d.settings).size(), 0U);
}

// The whole of it: particles alone leave nine tenths of this field bare.
TEST(AreaPoints, GiveOpenGroundSamplesWithoutGaps) {
  Scene scene = field();
  test::finish(scene);
  OptionValues options = test::default_options(lb_method());
  options.set("samples.count", 1500);
  options.set("samples.cluster_size", 250);
  options.set("samples.start", {kBesideTheHut.x(), kBesideTheHut.y(), kBesideTheHut.z()});
  test::InProcessBake bake(scene, options);
  auto kinds = test::kSamplingAndRays;
  kinds.erase("rays");
  test::run_kinds(bake, lb_method(), kinds);
  const SampleSet samples = test::samples_of(bake);
  double area = 0.0;
  for (const float a : samples.areas) area += a;
  // The field but the ground below the hut; hut; the wall's two sides. Cells end a little beyond
  // the disks, where the Poisson-disk set is not maximal.
  const double whole = 200.0 * 200.0 - 16.0 + (16.0 + 4 * 12.0) + 2 * 320.0;
  EXPECT_NEAR(area / whole, 1.0, 0.01);
}

}  // namespace
}  // namespace prt
