// The reference path tracer under environments, against closed forms.
#include <gtest/gtest.h>

#include "base/random.h"
#include "scene/embree/embree_ray_caster.h"
#include "statistical/closed_forms.h"
#include "statistical/test_scenes.h"
#include "statistical/z_test.h"
#include "transport/path_tracer.h"

namespace prt {
namespace {

using test::kPiD;
using test::ZFamily;

constexpr int kReplicates = 4000;
constexpr std::uint64_t kSeed = 11;

Environment constant_sky(const Vec3f& radiance) { return {2, 1, std::vector<Vec3f>(2, radiance)}; }

/// Direct and indirect irradiance of one channel at independent replicates.
struct Replicates {
  std::vector<double> direct, indirect;
};

Replicates trace(const Scene& scene, const Environment& sky,
                 const std::vector<ReceiverPoint>& points, int paths, Eigen::Index channel = 0) {
  const auto caster = make_embree_ray_caster(scene);
  Replicates all;
  for (const auto& e :
       trace_irradiance(scene, *caster, {}, points, {.paths = paths, .environment = &sky}, kSeed)) {
    all.direct.push_back(e.mean_direct()[channel]);
    all.indirect.push_back(e.mean_indirect()[channel]);
  }
  return all;
}

Replicates trace_at(const Scene& scene, const Environment& sky, const ReceiverPoint& point,
                    int paths, Eigen::Index channel = 0) {
  return trace(scene, sky, std::vector<ReceiverPoint>(kReplicates, point), paths, channel);
}

/// A speck far below: nothing is in the way.
Scene open_scene() {
  Scene scene;
  test::add_quad(scene, {0, -100, 0}, {0, 0, 0.1F}, {0.1F, 0, 0},
                 test::add_material(scene, Vec3f::Zero()));
  test::finish(scene);
  return scene;
}

TEST(SkyPaths, ConstantSkyBringsPiToEverySide) {
  const Scene scene = open_scene();
  const Environment sky = constant_sky({2, 1, 0});
  ZFamily family;
  for (const Vec3f& normal : {Vec3f(0, 1, 0), Vec3f(0, -1, 0), Vec3f(0.6F, 0, -0.8F)}) {
    family.add("red", trace_at(scene, sky, {Vec3f::Zero(), normal}, 16).direct, 2.0 * kPiD);
    family.add("green", trace_at(scene, sky, {Vec3f::Zero(), normal}, 16, 1).direct, kPiD);
  }
  family.check();
}

TEST(SkyPaths, ASunBringsItsRadianceTimesItsProjectedSolidAngle) {
  constexpr double kEdge = 2e-3;  // cells of 0.2 degrees along the rim
  const Scene scene = open_scene();
  for (const double radius : {5.0, 20.0}) {
    const Environment sky = parse_environment("disc:0,-1,0:3,3,3:" + std::to_string(radius));
    const auto lit = trace_at(scene, sky, {Vec3f::Zero(), Vec3f::UnitY()}, 16).direct;
    double mean = 0.0;
    for (const double e : lit) mean += e / kReplicates;
    const double sine = std::sin(radius * kPiD / 180.0);
    EXPECT_NEAR(mean / (3.0 * kPiD * sine * sine), 1.0, kEdge + 0.2 / radius * 0.05) << radius;
    for (const double e : trace_at(scene, sky, {Vec3f::Zero(), -Vec3f::UnitY()}, 16).direct) {
      ASSERT_EQ(e, 0.0);
    }
  }
}

TEST(SkyPaths, WallsHideTheSky) {
  Scene scene;
  test::add_box(scene, {-1, 0, -1}, {1, 2, 1}, test::add_material(scene, Vec3f::Zero()));
  std::erase_if(scene.triangles, [&](const Triangle& t) {
    return std::ranges::all_of(t.vertex,
                               [&](std::uint32_t v) { return scene.positions[v].y() > 1.9F; });
  });
  test::finish(scene);
  const auto floor = trace_at(scene, constant_sky({1, 1, 1}), {{0, 0, 0}, Vec3f::UnitY()}, 16);
  ZFamily family;
  family.add("floor", floor.direct, kPiD * test::parallel_rectangle(2, 2, 2));
  family.check();
  for (const double e : floor.indirect) ASSERT_EQ(e, 0.0);
}

// Inside a sphere every part exchanges the same with every other. Of one that is open in part, f of
// it being there, every point gets π L (1 − f) from a constant sky, and ρ f of what the others
// have. Level 4 facets stay within 0.25 % of the sphere's radius.
TEST(SkyPaths, ABowlReflectsAGeometricSeries) {
  constexpr double kFacetError = 0.01;
  for (const float rho : {0.5F, 0.9F}) {
    Scene scene;
    test::add_icosphere(scene, 4, test::add_material(scene, Vec3f::Constant(rho)));
    std::erase_if(scene.triangles, [&](const Triangle& t) {
      Vec3f sum = Vec3f::Zero();
      for (const std::uint32_t v : t.vertex) sum += scene.positions[v];
      return sum.y() > 0.0F;
    });
    test::finish(scene);
    double area = 0.0;
    std::vector<ReceiverPoint> points;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
      area += triangle_area(scene, t);
      points.push_back({triangle_point(scene, t, 1.0F / 3, 1.0F / 3), -triangle_normal(scene, t)});
    }
    const double f = area / (4.0 * kPiD);
    const auto means = trace(scene, constant_sky({1, 1, 1}), points, 64);
    double direct = 0.0, indirect = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double share = triangle_area(scene, static_cast<std::uint32_t>(i)) / area;
      direct += share * means.direct[i];
      indirect += share * means.indirect[i];
    }
    const double expected = kPiD * (1.0 - f);
    EXPECT_NEAR(direct / expected, 1.0, kFacetError) << rho;
    EXPECT_NEAR(indirect / (expected * rho * f / (1.0 - rho * f)), 1.0, 1.5 * kFacetError) << rho;
  }
}

TEST(SkyPaths, AddToLights) {
  const Scene scene = open_scene();
  const Environment sky = constant_sky({1, 1, 1});
  Light light;
  light.position = {0, 2, 0};
  light.intensity = Vec3f::Constant(8.0F);
  const auto caster = make_embree_ray_caster(scene);
  const std::vector<ReceiverPoint> points(kReplicates, {Vec3f::Zero(), Vec3f::UnitY()});
  std::vector<double> both;
  for (const auto& e : trace_irradiance(scene, *caster, {&light, 1}, points,
                                        {.paths = 16, .environment = &sky}, kSeed)) {
    both.push_back(e.mean_direct()[0]);
  }
  ZFamily family;
  family.add("light and sky", both, 2.0 + kPiD);
  family.check();
}

}  // namespace
}  // namespace prt
