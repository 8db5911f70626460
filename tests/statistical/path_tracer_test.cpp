// The reference path tracer against closed forms.
#include "transport/path_tracer.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "scene/embree/embree_ray_caster.h"
#include "statistical/closed_forms.h"
#include "statistical/test_scenes.h"
#include "statistical/z_test.h"

namespace prt {
namespace {

using test::kPiD;
using test::ZFamily;

/// Independent replicates of every estimate: their spread is then known to 1 %, and the estimates
/// themselves to a few tenths of a per cent, so that a bias of 1 % is seen.
constexpr int kReplicates = 4000;
constexpr std::uint64_t kSeed = 7;

/// Area-uniform points of the mesh, on its front side.
std::vector<ReceiverPoint> area_points(const Scene& scene, std::size_t count,
                                       std::uint64_t stream) {
  std::vector<double> cumulative;
  double total = 0.0;
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    cumulative.push_back(total += triangle_area(scene, t));
  }
  std::vector<ReceiverPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(stream, i);
    const double at = total * random.uniform();
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, at);
    const auto t = static_cast<std::uint32_t>(found - cumulative.begin());
    const float root = std::sqrt(random.uniform()), second = random.uniform();
    points.push_back({triangle_point(scene, t, root * (1.0F - second), root * second),
                      triangle_normal(scene, t)});
  }
  return points;
}

double total_area(const Scene& scene) {
  double area = 0.0;
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) area += triangle_area(scene, t);
  return area;
}

struct Replicates {
  std::vector<double> direct[3], indirect[3];
};

/// Each replicate is one random point of the mesh: the mean estimates the area mean.
Replicates area_mean(const Scene& scene, const Light& light, const PathTracerSettings& settings) {
  const auto caster = make_embree_ray_caster(scene);
  const auto points = area_points(scene, kReplicates, stream_key(kSeed, "test points"));
  const auto estimates = trace_irradiance(scene, *caster, {&light, 1}, points, settings, kSeed);
  Replicates result;
  for (const auto& e : estimates) {
    for (int c = 0; c < 3; ++c) {
      result.direct[c].push_back(e.mean_direct()[c]);
      result.indirect[c].push_back(e.mean_indirect()[c]);
    }
  }
  return result;
}

Replicates at_points(const Scene& scene, const Light& light,
                     const std::vector<ReceiverPoint>& points, const PathTracerSettings& settings) {
  const auto caster = make_embree_ray_caster(scene);
  const auto estimates = trace_irradiance(scene, *caster, {&light, 1}, points, settings, kSeed);
  Replicates result;
  for (const auto& e : estimates) {
    result.direct[0].push_back(e.mean_direct()[0]);
    result.indirect[0].push_back(e.mean_indirect()[0]);
  }
  return result;
}

/// The same point again and again with independent random numbers.
Replicates at_point(const Scene& scene, const Light& light, const ReceiverPoint& point,
                    const PathTracerSettings& settings) {
  return at_points(scene, light, std::vector<ReceiverPoint>(kReplicates, point), settings);
}

Light white_point(const Vec3f& position) {
  Light light;
  light.position = position;
  return light;
}

Light white_sun(const Vec3f& direction, float irradiance) {
  Light light;
  light.kind = Light::Kind::kSun;
  light.direction = direction;
  light.intensity = Vec3f::Constant(irradiance);
  return light;
}

Light white_quad(const Vec3f& centre, const Vec3f& u, const Vec3f& v, float radiance) {
  Light light;
  light.kind = Light::Kind::kQuad;
  light.position = centre;
  light.edge_u = u;
  light.edge_v = v;
  light.intensity = Vec3f::Constant(radiance);
  return light;
}

// In any closed space of uniform albedo rho with a point light I inside, light is conserved: all of
// 4 pi I arrives, and each bounce brings rho times the last. So the area means are exactly 4 pi I /
// A and rho / (1 - rho) times that, for the mesh as it is: no correction for its facets.
TEST(PathTracer, ClosedSphereConservesEnergy) {
  ZFamily family;
  for (const float rho : {0.0F, 0.5F, 0.9F, 0.99F}) {
    Scene scene;
    test::add_icosphere(scene, 3, test::add_material(scene, Vec3f::Constant(rho)));
    for (auto& t : scene.triangles) std::swap(t.vertex[1], t.vertex[2]);  // front sides inwards
    test::finish(scene);
    const auto means = area_mean(scene, white_point(Vec3f::Zero()), {.paths = 16});
    const double direct = 4.0 * kPiD / total_area(scene);
    family.add("direct", means.direct[0], direct);
    family.add("indirect, rho " + std::to_string(rho), means.indirect[0],
               direct * rho / (1.0 - rho));
    if (rho == 0.0F) {
      for (double e : means.indirect[0]) ASSERT_EQ(e, 0.0);
    }
  }
  family.check();
}

TEST(PathTracer, ClosedBoxConservesEnergyInEachChannel) {
  const Vec3f rho(0.8F, 0.5F, 0.1F);
  Scene scene;
  test::add_box(scene, Vec3f(-1, 0, -2), Vec3f(3, 2, 1), test::add_material(scene, rho));
  test::finish(scene);
  const auto means = area_mean(scene, white_point(Vec3f(0.5F, 1.2F, -0.4F)), {.paths = 16});
  const double direct = 4.0 * kPiD / total_area(scene);
  ZFamily family;
  for (int c = 0; c < 3; ++c) {
    family.add("direct", means.direct[c], direct);
    family.add("indirect", means.indirect[c], direct * rho[c] / (1.0 - rho[c]));
  }
  family.check();
}

TEST(PathTracer, BounceLimitCutsTheSeries) {
  const float rho = 0.7F;
  Scene scene;
  test::add_box(scene, Vec3f(-1, -1, -1), Vec3f(1, 1, 1),
                test::add_material(scene, Vec3f::Constant(rho)));
  test::finish(scene);
  const double direct = 4.0 * kPiD / total_area(scene);
  ZFamily family;
  double series = 0.0;
  for (int bounces = 0; bounces <= 6; ++bounces) {
    if (bounces > 0) series += std::pow(rho, bounces);
    const auto means =
        area_mean(scene, white_point(Vec3f::Zero()), {.paths = 8, .bounces = bounces});
    family.add(std::to_string(bounces) + " bounces", means.indirect[0], direct * series);
  }
  family.check();
}

// On a sphere every pair of points exchanges the same, so indirect light is uniform too. Level 4
// facets stay within 0.25 % of the sphere's radius.
TEST(PathTracer, SphereIsUniform) {
  constexpr double kFacetError = 0.01;
  Scene scene;
  test::add_icosphere(scene, 4, test::add_material(scene, Vec3f::Constant(0.5F)));
  test::finish(scene);
  const Vec3f corner = scene.positions[0];
  const auto means =
      at_point(scene, white_point(Vec3f::Zero()), {0.999F * corner, -corner}, {.paths = 32});
  double mean = 0.0;
  for (double e : means.indirect[0]) mean += e / kReplicates;
  EXPECT_NEAR(mean, 1.0, kFacetError);
}

TEST(PathTracer, PointLightOverPlaneIsExact) {
  Scene scene;
  test::add_quad(scene, Vec3f(-5, 0, -5), Vec3f(0, 0, 10), Vec3f(10, 0, 0),
                 test::add_material(scene, Vec3f::Constant(0.9F)));
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  Light light = white_point(Vec3f(0, 2, 0));
  light.intensity = Vec3f(3, 5, 7);
  for (const float x : {0.0F, 1.0F, 4.5F}) {
    const ReceiverPoint point{Vec3f(x, 0, 0), Vec3f::UnitY()};
    const auto e = trace_irradiance(scene, *caster, {&light, 1}, {&point, 1}, {}, kSeed)[0];
    const double squared = 4.0 + x * x;
    for (int c = 0; c < 3; ++c) {
      const double truth = light.intensity[c] * (2.0 / std::sqrt(squared)) / squared;
      EXPECT_NEAR(e.mean_direct()[c], truth, test::kRounding * truth);
    }
    EXPECT_EQ(e.direct[0], e.direct[1]);
    EXPECT_EQ(e.mean_indirect(), Vec3f::Zero().eval());
  }
  // From below, the plane hides the light.
  const ReceiverPoint below{Vec3f(1, 0, 1), -Vec3f::UnitY()};
  EXPECT_EQ(trace_irradiance(scene, *caster, {&light, 1}, {&below, 1}, {}, kSeed)[0].mean_direct(),
            Vec3f::Zero().eval());
}

TEST(PathTracer, SurfacesHideTheLight) {
  Scene scene;
  const auto grey = test::add_material(scene, Vec3f::Constant(0.5F));
  test::add_box(scene, Vec3f(-2, 0, -2), Vec3f(2, 4, 2), grey);
  test::add_box(scene, Vec3f(-1, 2, -1), Vec3f(1, 3, 1), grey);
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  // A light inside the closed inner box lights nothing outside, one outside lights nothing inside.
  const ReceiverPoint floor{Vec3f(0.3F, 0, 0.1F), Vec3f::UnitY()};
  const ReceiverPoint inside{Vec3f(0.3F, 2, 0.1F), Vec3f::UnitY()};
  for (const bool light_inside : {true, false}) {
    const Light light = white_point(light_inside ? Vec3f(0, 2.5F, 0) : Vec3f(0, 1, 0));
    const ReceiverPoint points[] = {floor, inside};
    const auto e = trace_irradiance(scene, *caster, {&light, 1}, points, {.paths = 256}, kSeed);
    const auto& dark = e[light_inside ? 0 : 1];
    const auto& lit = e[light_inside ? 1 : 0];
    EXPECT_EQ(dark.mean_direct(), Vec3f::Zero().eval());
    EXPECT_EQ(dark.mean_indirect(), Vec3f::Zero().eval());
    EXPECT_GT(lit.mean_direct()[0], 0.0F);
    EXPECT_GT(lit.mean_indirect()[0], 0.0F);
  }
}

// A floor in the sun sends radiance rho E / pi up to a point that faces it.
TEST(PathTracer, SunlitFloorSeenFromAbove) {
  const Vec3f rho = Vec3f::Constant(0.6F);
  Scene scene;
  test::add_quad(scene, Vec3f(-1, 0, -2), Vec3f(0, 0, 4), Vec3f(2, 0, 0),
                 test::add_material(scene, rho));
  test::finish(scene);
  const Light sun = white_sun(-Vec3f::UnitY(), 10.0F);
  const auto means = at_point(scene, sun, {Vec3f(0, 1.5F, 0), -Vec3f::UnitY()}, {.paths = 32});
  ZFamily family;
  family.add("indirect", means.indirect[0], 0.6 * 10.0 * test::parallel_rectangle(2.0, 4.0, 1.5));
  family.check();
}

TEST(PathTracer, AreaLightsMatchFormFactors) {
  Scene scene;
  test::add_quad(scene, Vec3f(-5, 0, -5), Vec3f(0, 0, 10), Vec3f(10, 0, 0),
                 test::add_material(scene, Vec3f::Constant(0.5F)));
  test::finish(scene);
  const ReceiverPoint point{Vec3f::Zero(), Vec3f::UnitY()};
  // u × v points down
  const Light quad = white_quad(Vec3f(0, 1.5F, 0), Vec3f(2, 0, 0), Vec3f(0, 0, 4), 3.0F);
  Light sphere = white_point(Vec3f(0, 2, 0));
  sphere.kind = Light::Kind::kSphere;
  sphere.radius = 0.8F;
  ZFamily family;
  family.add("quad", at_point(scene, quad, point, {.paths = 32}).direct[0],
             3.0 * kPiD * test::parallel_rectangle(2.0, 4.0, 1.5));
  // A sphere wholly above the horizon, seen along the normal: pi L (R/d)^2 = I / d^2.
  family.add("sphere", at_point(scene, sphere, point, {.paths = 32}).direct[0], 1.0 / 4.0);
  family.check();
}

// (r1 - r2)² / 4 must have the variance of the mean as its own mean.
TEST(PathTracer, HalvesTellTheNoiseHonestly) {
  // Ratio of two variances from 4000 replicates each: relative spread 3 %; four of those.
  constexpr double kRatioTolerance = 0.13;
  Scene scene;
  test::add_box(scene, Vec3f(-1, 0, -2), Vec3f(3, 2, 1),
                test::add_material(scene, Vec3f::Constant(0.6F)));
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  const Light light = white_point(Vec3f(0.5F, 1.2F, -0.4F));
  const std::vector<ReceiverPoint> points(kReplicates, {Vec3f(0, 0, 0), Vec3f::UnitY()});
  const auto estimates =
      trace_irradiance(scene, *caster, {&light, 1}, points, {.paths = 32}, kSeed);
  double mean = 0.0, variance = 0.0, told = 0.0;
  for (const auto& e : estimates) mean += e.mean_indirect()[0] / kReplicates;
  for (const auto& e : estimates) {
    variance += std::pow(e.mean_indirect()[0] - mean, 2) / (kReplicates - 1);
    told += std::pow(0.5 * (e.indirect[0][0] - e.indirect[1][0]), 2) / kReplicates;
  }
  EXPECT_GT(variance, 0.0);
  EXPECT_NEAR(told / variance, 1.0, kRatioTolerance);
}

/// Points uniform over a parallelogram that receives on the side of u × v; it need not be there.
std::vector<ReceiverPoint> patch_points(const Vec3f& corner, const Vec3f& u, const Vec3f& v) {
  std::vector<ReceiverPoint> points;
  for (int i = 0; i < kReplicates; ++i) {
    Random random(stream_key(kSeed, "patch"), static_cast<std::uint64_t>(i));
    const float a = random.uniform(), b = random.uniform();
    points.push_back({corner + a * u + b * v, u.cross(v).normalized()});
  }
  return points;
}

// A sunlit floor shines on a patch: rho E times the view factor from the patch to the floor.
TEST(PathTracer, SunlitFloorSeenFromFacingAndUprightPatches) {
  const float w = 0.7F, h = 1.3F;
  Scene scene;
  test::add_quad(scene, Vec3f::Zero(), Vec3f(0, 0, 1), Vec3f(w, 0, 0),
                 test::add_material(scene, Vec3f::Constant(0.6F)));
  test::finish(scene);
  const Light sun = white_sun(-Vec3f::UnitY(), 10.0F);
  const auto facing = patch_points(Vec3f(0, 1, 0), Vec3f(w, 0, 0), Vec3f(0, 0, 1));
  const auto upright = patch_points(Vec3f::Zero(), Vec3f(0, h, 0), Vec3f(0, 0, 1));
  ZFamily family;
  family.add("facing", at_points(scene, sun, facing, {.paths = 32}).indirect[0],
             6.0 * test::facing_rectangles(w, 1.0));
  family.add("upright", at_points(scene, sun, upright, {.paths = 32}).indirect[0],
             6.0 * test::rectangles_at_right_angle(w, h) * w / h);  // reciprocity of view factors
  family.check();
}

TEST(PathTracer, SunAndSpotAreExact) {
  Scene scene;
  test::add_quad(scene, Vec3f(-5, 0, -5), Vec3f(0, 0, 10), Vec3f(10, 0, 0),
                 test::add_material(scene, Vec3f::Constant(0.9F)));
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  const auto direct = [&](const Light& light, const Vec3f& at) {
    const ReceiverPoint point{at, Vec3f::UnitY()};
    return trace_irradiance(scene, *caster, {&light, 1}, {&point, 1}, {}, kSeed)[0]
        .mean_direct()[0];
  };
  const Light sun = white_sun(Vec3f(0.6F, -0.8F, 0.0F), 5.0F);
  EXPECT_NEAR(direct(sun, Vec3f(1, 0, 2)), 5.0 * 0.8, 4.0 * test::kRounding);

  Light spot = white_point(Vec3f(0, 2, 0));
  spot.kind = Light::Kind::kSpot;
  spot.inner_angle = 0.3F;
  spot.outer_angle = 0.6F;
  for (const double angle : {0.0, 0.25, 0.4, 0.55, 0.65}) {
    const double cosine = std::cos(angle);
    const double along = (cosine - std::cos(0.6)) / (std::cos(0.3) - std::cos(0.6));
    const double falloff = std::pow(std::clamp(along, 0.0, 1.0), 2);
    // Distance 2 / cos, and the floor is tilted by the same angle.
    const double truth = falloff * std::pow(cosine, 3) / 4.0;
    const Vec3f at(static_cast<float>(2.0 * std::tan(angle)), 0, 0);
    EXPECT_NEAR(direct(spot, at), truth, 10.0 * test::kRounding * 0.25) << angle;
  }
}

TEST(PathTracer, QuadLightMatchesLambertsFormula) {
  Scene scene;  // nothing in the way
  test::add_quad(scene, Vec3f(-5, -9, -5), Vec3f(0, 0, 10), Vec3f(10, 0, 0),
                 test::add_material(scene, Vec3f::Constant(0.5F)));
  test::finish(scene);
  // u × v points down
  const Light quad =
      white_quad(Vec3f(0.4F, 1.5F, 0.2F), Vec3f(2, 0.5F, 0), Vec3f(0, 0.3F, 3), 3.0F);
  ZFamily family;
  for (const Vec3f& towards : {Vec3f(0, 1, 0), Vec3f(0.5F, 0.8F, 0.1F), Vec3f(1, 0.2F, -0.3F)}) {
    const Vec3f normal = towards.normalized();
    std::vector<Vec3d> corners;
    for (const auto& [a, b] : {std::pair{-0.5F, -0.5F}, {0.5F, -0.5F}, {0.5F, 0.5F}, {-0.5F, 0.5F}})
      corners.emplace_back((quad.position + a * quad.edge_u + b * quad.edge_v).cast<double>());
    family.add("normal " + std::to_string(normal.x()),
               at_point(scene, quad, {Vec3f::Zero(), normal}, {.paths = 32}).direct[0],
               3.0 * test::lambert_polygon(corners, normal.cast<double>()));
  }
  family.check();
}

// What patch A sends to B by way of all bounces is what B sends to A.
TEST(PathTracer, PatchesExchangeTheSameEitherWay) {
  Scene scene;
  test::add_box(scene, Vec3f(-1, 0, -2), Vec3f(3, 2, 1),
                test::add_material(scene, Vec3f::Constant(0.7F)));
  test::add_box(scene, Vec3f(0.5F, 0.2F, -1), Vec3f(1, 1.2F, 0),
                test::add_material(scene, Vec3f::Constant(0.2F)));
  test::finish(scene);
  struct Patch {
    Vec3f corner, u, v;
    [[nodiscard]] Light light() const { return white_quad(corner + 0.5F * (u + v), u, v, 1.0F); }
    [[nodiscard]] double area() const { return u.cross(v).norm(); }
  };
  const Patch a{Vec3f(-0.8F, 0.1F, -1.5F), Vec3f(0, 0, 1), Vec3f(0.5F, 0, 0)};  // up
  const Patch b{Vec3f(2.7F, 0.5F, -1), Vec3f(0, 0, 1.5F), Vec3f(0, 1, 0)};      // towards -x
  const auto flux = [&](const Patch& from, const Patch& to) {
    std::vector<double> sums;
    const auto found =
        at_points(scene, from.light(), patch_points(to.corner, to.u, to.v), {.paths = 32});
    for (double e : found.indirect[0]) sums.push_back(to.area() * e);
    return sums;
  };
  const std::vector<double> there = flux(a, b), back = flux(b, a);
  std::vector<double> difference;
  double mean = 0.0;
  for (std::size_t i = 0; i < there.size(); ++i) {
    difference.push_back(there[i] - back[i]);
    mean += there[i] / kReplicates;
  }
  EXPECT_GT(mean, 0.0);
  ZFamily family;
  family.add("A to B less B to A", difference, 0.0);
  family.check();
}

// Over many seeds, squared deviations in units of the standard error that the halves tell sum to
// chi-squared.
TEST(PathTracer, StandardErrorIsTheScatterOverSeeds) {
  constexpr int kSeeds = 600;
  constexpr std::size_t kPoints = 32;  // a mean of so many is normally distributed
  Scene scene;
  test::add_box(scene, Vec3f(-1, 0, -2), Vec3f(3, 2, 1),
                test::add_material(scene, Vec3f::Constant(0.6F)));
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  const Light light = white_point(Vec3f(0.5F, 1.2F, -0.4F));
  const std::vector<ReceiverPoint> points(kPoints, {Vec3f::Zero(), Vec3f::UnitY()});
  std::vector<double> means;
  double told = 0.0, mean = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto stream = stream_key(static_cast<std::uint64_t>(seed), "standard error");
    double sum = 0.0;
    for (const auto& e :
         trace_irradiance(scene, *caster, {&light, 1}, points, {.paths = 16}, stream)) {
      sum += e.mean_indirect()[0] / kPoints;
      const double half = 0.5 * (e.indirect[0][0] - e.indirect[1][0]);
      told += half * half / (kPoints * kPoints) / kSeeds;
    }
    means.push_back(sum);
    mean += sum / kSeeds;
  }
  ASSERT_GT(told, 0.0);
  double chi_squared = 0.0;
  for (double m : means) chi_squared += (m - mean) * (m - mean) / told;
  // Wilson & Hilferty 1931: the cube root of chi-squared over its degrees is nearly normal.
  const double spread = 2.0 / (9.0 * (kSeeds - 1));
  const double z = (std::cbrt(chi_squared / (kSeeds - 1)) - (1.0 - spread)) / std::sqrt(spread);
  EXPECT_GE(test::p_value(z), test::kFamilyWiseError)
      << "variance over what the halves tell: " << chi_squared / (kSeeds - 1);
}

TEST(PathTracer, RangesGiveTheSamePoints) {
  Scene scene;
  test::add_box(scene, Vec3f(-1, 0, -2), Vec3f(3, 2, 1),
                test::add_material(scene, Vec3f(0.6F, 0.3F, 0.9F)));
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  const Light light = white_point(Vec3f(0.5F, 1.2F, -0.4F));
  const auto points = area_points(scene, 96, stream_key(kSeed, "test points"));
  const std::span all(points);
  const auto whole = trace_irradiance(scene, *caster, {&light, 1}, all, {}, kSeed);
  const auto part = trace_irradiance(scene, *caster, {&light, 1}, all.subspan(64), {}, kSeed, 64);
  for (std::size_t i = 0; i < part.size(); ++i) {
    EXPECT_EQ(whole[64 + i].indirect, part[i].indirect);
    EXPECT_EQ(whole[64 + i].direct, part[i].direct);
  }
  EXPECT_NE(whole[0].indirect[0], whole[0].indirect[1]);
}

}  // namespace
}  // namespace prt
