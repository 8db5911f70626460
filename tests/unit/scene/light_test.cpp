// Lights against closed forms.
#include "scene/light.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/error.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

/// Rounding of a few float operations, relative.
constexpr float kRounding = 1e-5F;
/// Midpoint rule on kGrid² points; the smooth integrands here converge with its square.
constexpr int kGrid = 256;
constexpr float kQuadrature = 2e-4F;

/// Irradiance at p on a plane with normal n, averaged over a grid of (u, v).
float irradiance(const Light& light, const Vec3f& p, const Vec3f& n) {
  double sum = 0.0;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      const IncidentLight sample = incident_light(light, p, (static_cast<float>(i) + 0.5F) / kGrid,
                                                  (static_cast<float>(j) + 0.5F) / kGrid);
      EXPECT_NEAR(sample.to_light.norm(), 1.0F, kRounding);
      sum += sample.irradiance.x() * std::max(0.0F, n.dot(sample.to_light));
    }
  }
  return static_cast<float>(sum / (kGrid * kGrid));
}

Light point_like(Light::Kind kind, const Vec3f& position, float intensity, float radius = 0.0F) {
  Light light;
  light.kind = kind;
  light.position = position;
  light.intensity = Vec3f::Constant(intensity);
  light.radius = radius;
  return light;
}

TEST(Light, PointFollowsTheInverseSquare) {
  const Light light = point_like(Light::Kind::kPoint, {0, 2, 0}, 12);
  const IncidentLight sample = incident_light(light, Vec3f::Zero(), 0, 0);
  EXPECT_FLOAT_EQ(sample.irradiance.y(), 3.0F);
  EXPECT_FLOAT_EQ(sample.distance, 2.0F);
  EXPECT_EQ(sample.to_light, Vec3f(0, 1, 0));
  EXPECT_EQ(incident_light(light, light.position, 0, 0).irradiance, Vec3f::Zero());
  EXPECT_TRUE(is_punctual(light));
}

TEST(Light, SphereAboveTheHorizonIsAPoint) {
  // A uniform sphere fully above the horizon gives L·π·sin²θ_max·cos θ = I·cos θ/d², at any size.
  const Vec3f n = Vec3f(1, 3, 0).normalized();
  for (const float radius : {1e-4F, 0.3F, 1.5F}) {
    const Light light = point_like(Light::Kind::kSphere, {0, 2, 0}, 12, radius);
    EXPECT_NEAR(irradiance(light, Vec3f::Zero(), n), 3.0F * n.y(), 3.0F * kQuadrature) << radius;
  }
  EXPECT_FALSE(is_punctual(point_like(Light::Kind::kSphere, {0, 2, 0}, 12, 1)));
}

TEST(Light, SphereCutByTheHorizon) {
  // Centre on the horizon: half the cone, ∫ = σ − sin σ cos σ with sin σ = R/d.
  const float radius = 1.2F;
  const Light light = point_like(Light::Kind::kSphere, {2, 0, 0}, 5, radius);
  const float sigma = std::asin(radius / 2.0F);
  const float expected =
      5.0F / (kPi * radius * radius) * (sigma - std::sin(sigma) * std::cos(sigma));
  EXPECT_NEAR(irradiance(light, Vec3f::Zero(), Vec3f::UnitY()), expected, expected * kQuadrature);
}

TEST(Light, SphereSamplesLieOnTheSphere) {
  const Light light = point_like(Light::Kind::kSphere, {1, 2, 3}, 5, 0.7F);
  for (const Vec3f& p :
       {Vec3f(0, 0, 0), Vec3f(1, 2, 3.69F), Vec3f(1, 2, 3.71F), Vec3f(1.2F, 2, 3)}) {
    for (int i = 0; i < 64; ++i) {
      const float u = (static_cast<float>(i) + 0.5F) / 64.0F;
      const IncidentLight sample = incident_light(light, p, u, std::fmod(u * 13.0F, 1.0F));
      const Vec3f end = p + sample.distance * sample.to_light;
      // Near the limb the root amplifies rounding to its square root.
      EXPECT_NEAR((end - light.position).norm(), 0.7F, 2e-3F);
      EXPECT_GE(sample.distance, 0.0F);
    }
  }
}

TEST(Light, SphereIsContinuousAtItsSurface) {
  const Light light = point_like(Light::Kind::kSphere, Vec3f::Zero(), 5, 1);
  // Radiance 5/π over half the sphere, seen from just inside and just outside.
  EXPECT_NEAR(irradiance(light, {0, 0.9999F, 0}, -Vec3f::UnitY()), 5.0F, 0.01F);
  EXPECT_NEAR(irradiance(light, {0, 1.0001F, 0}, -Vec3f::UnitY()), 5.0F, 0.01F);
}

TEST(Light, SpotFallsOffAsGltfSays) {
  Light light = point_like(Light::Kind::kSpot, {0, 1, 0}, 4);
  light.direction = -Vec3f::UnitY();
  light.inner_angle = 0.2F;
  light.outer_angle = 0.6F;
  const auto at = [&](float angle) {
    const Vec3f p(std::tan(angle), 0, 0);
    const float r2 = 1.0F + p.x() * p.x();
    return incident_light(light, p, 0, 0).irradiance.x() * r2 / 4.0F;
  };
  EXPECT_NEAR(at(0.0F), 1.0F, kRounding);
  EXPECT_NEAR(at(0.199F), 1.0F, kRounding);
  EXPECT_LT(at(0.21F), 1.0F);
  EXPECT_GT(at(0.59F), 0.0F);
  EXPECT_EQ(at(0.601F), 0.0F);
  const float linear = (std::cos(0.4F) - std::cos(0.6F)) / (std::cos(0.2F) - std::cos(0.6F));
  EXPECT_NEAR(at(0.4F), linear * linear, kRounding);
  EXPECT_EQ(incident_light(light, {0, 5, 0}, 0, 0).irradiance, Vec3f::Zero()) << "behind it";
  EXPECT_TRUE(is_punctual(light));
}

TEST(Light, QuadMatchesTheFormFactor) {
  Light light = point_like(Light::Kind::kQuad, {0, 1.5F, 0}, 7);
  light.edge_u = {2, 0, 0};
  light.edge_v = {0, 0, 1.2F};  // u × v points down
  ASSERT_LT(light.edge_u.cross(light.edge_v).y(), 0.0F);
  // Four corner rectangles of a × b at height h (e.g. Howell, configuration C-11).
  const float x = 1.0F / 1.5F;
  const float y = 0.6F / 1.5F;
  const float rx = std::sqrt(1.0F + x * x);
  const float ry = std::sqrt(1.0F + y * y);
  const float factor =
      4.0F / (2.0F * kPi) * (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry));
  const float expected = kPi * 7.0F * factor;
  EXPECT_NEAR(irradiance(light, Vec3f::Zero(), Vec3f::UnitY()), expected, expected * kQuadrature);
  EXPECT_EQ(irradiance(light, {0, 3, 0}, -Vec3f::UnitY()), 0.0F) << "its back is dark";
}

TEST(Light, SunIsParallel) {
  Light light = point_like(Light::Kind::kSun, Vec3f::Zero(), 3);
  light.direction = Vec3f(0, -1, 0);
  const IncidentLight sample = incident_light(light, {5, 6, 7}, 0.3F, 0.4F);
  EXPECT_EQ(sample.to_light, Vec3f(0, 1, 0));
  EXPECT_EQ(sample.distance, kInfinity);
  EXPECT_EQ(sample.irradiance, Vec3f::Constant(3));
}

/// In a scene about the world's own origin.
Light placed(const char* spec) { return parse_light(spec).in(Vec3d::Zero()); }

TEST(LightSpec, PlacesAreTakenToTheSceneInDouble) {
  // 2^-13 m at 123456 m: in float the two would be one place.
  const Vec3d origin(123456, -65536, 0);
  EXPECT_EQ(parse_light("point:123456.0001220703125,-65534,3:1,1,1").in(origin).position,
            Vec3f(0x1p-13F, 2, 3));
  const WorldLight quad = parse_light("quad:123457,0,0:1,0,0:0,0,2:3,3,3");
  EXPECT_EQ(quad.in(origin).position, Vec3f(1, 65536, 0));
  EXPECT_EQ(quad.in(origin).edge_v, Vec3f(0, 0, 2)) << "a length, not a place";
  const Light sun = parse_light("sun:0,-1,0:1,2,3").in(origin);
  EXPECT_EQ(sun.position, Vec3f::Zero()) << "it has none";
  EXPECT_EQ(sun.direction, Vec3f(0, -1, 0));
  const std::vector<WorldLight> two = {parse_light("point:123457,0,0:1,1,1"), quad};
  EXPECT_EQ(lights_in(origin, two)[1].position, Vec3f(1, 65536, 0));
}

TEST(LightSpec, ReadsEveryForm) {
  const Light point = placed("point:1,-2,3e-1:4,5,6");
  EXPECT_EQ(point.kind, Light::Kind::kPoint);
  EXPECT_EQ(point.position, Vec3f(1, -2, 0.3F));
  EXPECT_EQ(point.intensity, Vec3f(4, 5, 6));
  EXPECT_EQ(placed("sphere:0,0,0:1,1,1:0.25").radius, 0.25F);
  const Light spot = placed("spot:0,3,0:0,-2,0:1,1,1:15,30");
  EXPECT_EQ(spot.direction, Vec3f(0, -1, 0));
  EXPECT_NEAR(spot.inner_angle, kPi / 12.0F, kRounding);
  EXPECT_NEAR(spot.outer_angle, kPi / 6.0F, kRounding);
  const Light quad = placed("quad:0,2,0:1,0,0:0,0,2:3,3,3");
  EXPECT_EQ(quad.edge_v, Vec3f(0, 0, 2));
  EXPECT_EQ(quad.intensity, Vec3f(3, 3, 3));
  EXPECT_EQ(placed("sun:0,-1,0:1,2,3").intensity, Vec3f(1, 2, 3));
}

TEST(LightSpec, RefusesRubbish) {
  for (const char* spec : {"",
                           "lamp",
                           "lamp:1,2,3:1,1,1",
                           "point",
                           "point:",
                           "point:1,2:1,1,1",
                           "point:1,2,3",
                           "point:1,2,3:1,1,1:1",
                           "point:1,2,x:1,1,1",
                           "point:1,2,3:1,1,",
                           "point:1,2,nan:1,1,1",
                           "point:1,2,inf:1,1,1",
                           "point:1,2,1e99:1,1,1",
                           "point:1,2,3:-1,1,1",
                           "point: 1,2,3:1,1,1",
                           "sphere:0,0,0:1,1,1:0",
                           "sphere:0,0,0:1,1,1:-1",
                           "sphere:0,0,0:1,1,1",
                           "spot:0,0,0:0,0,0:1,1,1:10,20",
                           "spot:0,0,0:0,1,0:1,1,1:30,20",
                           "spot:0,0,0:0,1,0:1,1,1:-1,20",
                           "spot:0,0,0:0,1,0:1,1,1:10,91",
                           "quad:0,0,0:1,0,0:2,0,0:1,1,1",
                           "quad:0,0,0:0,0,0:1,0,0:1,1,1",
                           "sun:0,0,0:1,1,1"}) {
    try {
      parse_light(spec);
      ADD_FAILURE() << spec;
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()).find(spec), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace prt
