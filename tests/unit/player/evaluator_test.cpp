#include "player/evaluator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"
#include "bases/depth_basis.h"
#include "player/light_samples.h"
#include "player/picture.h"
#include "player/set_up.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

using test::synthetic_room;

/// Sums of a few hundred floats in another order.
constexpr float kRounding = 1e-5F;

Light point_light(const Vec3f& position, const Vec3f& intensity = Vec3f(3, 2, 1)) {
  Light light;
  light.position = position;
  light.intensity = intensity;
  return light;
}

SampleIrradiance play(const Evaluator& evaluator, const std::vector<Light>& lights) {
  return evaluator.evaluate(lights);
}

TEST(Evaluator, DirectLightIsIntensityTimesCosineOverDistanceSquared) {
  const Package room = synthetic_room({.directions = 0});
  const Evaluator evaluator(room);
  const Light light = point_light({1.5F, 2.0F, 2.5F});
  const SampleIrradiance played = play(evaluator, {light});
  for (std::size_t i = 0; i < room.samples.size(); ++i) {
    const Vec3f offset = light.position - room.samples.positions[i];
    const float geometry = room.samples.normals[i].dot(offset) / std::pow(offset.norm(), 3.0F);
    const Vec3f expected = geometry * light.intensity;
    const Vec3f value = played.direct.row(static_cast<Eigen::Index>(i)).transpose();
    ASSERT_TRUE(value.isApprox(expected, kRounding)) << value.transpose();
    ASSERT_EQ(played.visibility[0][i], 1.0F);
  }
}

TEST(Evaluator, IndirectLightOfAFurnaceIsTheGeometricSeries) {
  const test::SyntheticRoom settings{.albedo = Vec3f(0.2F, 0.5F, 0.8F)};
  const Package room = synthetic_room(settings);
  const SampleIrradiance played = play(Evaluator(room), {point_light({1, 1, 1})});
  Vec3d mean = Vec3d::Zero();
  double area = 0.0;
  for (std::size_t i = 0; i < room.samples.size(); ++i) {
    const Vec3f direct = played.direct.row(static_cast<Eigen::Index>(i)).transpose();
    mean += static_cast<double>(room.samples.areas[i]) * direct.cast<double>();
    area += room.samples.areas[i];
  }
  mean /= area;
  for (int c = 0; c < 3; ++c) {
    const double expected = mean[c] * settings.albedo[c] / (1.0 - settings.albedo[c]);
    for (Eigen::Index i = 0; i < played.indirect.rows(); ++i) {
      ASSERT_NEAR(played.indirect(i, c), expected, kRounding * expected);
    }
  }
}

TEST(Evaluator, RespondsToGivenDirectLightAsToItsOwn) {
  const Package room = synthetic_room({.albedo = Vec3f(0.2F, 0.5F, 0.8F)});
  const Evaluator evaluator(room);
  const SampleIrradiance played = play(evaluator, {point_light({1, 1, 1})});
  EXPECT_EQ(evaluator.respond(played.direct), played.indirect);
  EXPECT_TRUE(evaluator.respond(2.0F * played.direct).isApprox(2.0F * played.indirect, kRounding));
  EXPECT_TRUE(evaluator.respond(MatrixF::Zero(played.direct.rows(), 3)).isZero(0.0F));
}

TEST(Evaluator, OneGreyChannelServesAllThree) {
  const Package grey = synthetic_room({.channels = 1});
  const Package coloured = synthetic_room({.channels = 3});
  const std::vector<Light> lights{point_light({1, 1, 1}, {5, 2, 0.5F})};
  const SampleIrradiance a = play(Evaluator(grey), lights);
  const SampleIrradiance b = play(Evaluator(coloured), lights);
  EXPECT_TRUE(a.indirect.isApprox(b.indirect, kRounding));
}

TEST(Evaluator, NearSendersAddTheirShareOfDirectLight) {
  constexpr float kShareRounding = 3e-5F;  // 16 bits, twice, of products up to 0.4
  for (const std::uint32_t channels : {3U, 1U}) {
    const std::vector<Light> lights{point_light({1, 1, 1})};
    const SampleIrradiance without = play(Evaluator(synthetic_room()), lights);
    Package room = synthetic_room();
    test::add_near(room, channels);
    validate(room, "room");
    const SampleIrradiance played = play(Evaluator(room), lights);
    EXPECT_EQ(played.direct, without.direct);
    const Eigen::Index n = played.direct.rows();
    const Vec3f albedo = channels == 3 ? Vec3f(0.2F, 0.4F, 0.8F) : Vec3f::Constant(0.4F);
    for (Eigen::Index r = 0; r < n; ++r) {
      for (int c = 0; c < 3; ++c) {
        const float sent =
            0.25F * played.direct((r + 7) % n, c) + 0.5F * played.direct((r + 50) % n, c);
        ASSERT_NEAR(played.indirect(r, c) - without.indirect(r, c), albedo[c] * sent,
                    kShareRounding * played.direct.maxCoeff());
      }
    }
  }
}

TEST(Evaluator, WallsLetInWhatIsWithinThem) {
  const Vec3f size = test::SyntheticRoom().size;
  Package room = synthetic_room();
  const Package unshadowed = synthetic_room({.directions = 0});
  test::see_up_to_walls(room, size);
  validate(room, "room");
  const Evaluator evaluator(room);
  const Evaluator free(unshadowed);
  const std::vector<Light> inside = {
      point_light(0.3F * size), point_light({0.5F * size.x(), size.y(), 0.5F * size.z()}),
      Light{.kind = Light::Kind::kSphere, .position = 0.5F * size, .radius = 0.2F}};
  for (const Light& light : inside) {
    EXPECT_EQ(play(evaluator, {light}).direct, play(free, {light}).direct);
  }
  // The walls are closed on every side, to the sun as well.
  std::vector<Light> outside;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-0.01F, 1.01F}) {
      Vec3f p = 0.4F * size;
      p[axis] = side * size[axis];
      outside.push_back(point_light(p));
      Light sun{.kind = Light::Kind::kSun};
      sun.direction = (0.5F * size - p).normalized();
      outside.push_back(sun);
    }
  }
  for (const Light& light : outside) {
    EXPECT_FALSE(play(free, {light}).direct.isZero(0.0F));
    EXPECT_TRUE(play(evaluator, {light}).direct.isZero(0.0F));
  }
}

TEST(Evaluator, TwiceThePowerIsExactlyTwiceTheLight) {
  Package room = synthetic_room({.bits = 8});
  test::add_near(room);
  const Evaluator evaluator(room);
  for (Light light :
       {point_light({1, 2, 3}),
        Light{.kind = Light::Kind::kSphere, .position = Vec3f(1, 2, 3), .radius = 0.3F}}) {
    const SampleIrradiance once = play(evaluator, {light});
    light.intensity *= 2.0F;
    const SampleIrradiance twice = play(evaluator, {light});
    EXPECT_EQ(MatrixF(2.0F * once.direct), twice.direct);
    EXPECT_EQ(MatrixF(2.0F * once.indirect), twice.indirect);
  }
}

TEST(Evaluator, TwoLightsAreTheSum) {
  const Package room = synthetic_room({.bits = 8});
  const Evaluator evaluator(room);
  const Light a = point_light({1, 2, 3});
  const Light b = point_light({3, 1, 1}, {1, 1, 7});
  const SampleIrradiance both = play(evaluator, {a, b});
  const SampleIrradiance only_a = play(evaluator, {a});
  const SampleIrradiance only_b = play(evaluator, {b});
  EXPECT_TRUE(both.direct.isApprox(only_a.direct + only_b.direct, kRounding));
  EXPECT_TRUE(both.indirect.isApprox(only_a.indirect + only_b.indirect, kRounding));
}

TEST(Evaluator, NoLightIsExactlyDark) {
  const Package room = synthetic_room();
  const Evaluator evaluator(room);
  for (const std::vector<Light>& lights :
       {std::vector<Light>{}, {point_light({1, 1, 1}, Vec3f::Zero())}}) {
    const SampleIrradiance played = play(evaluator, lights);
    EXPECT_EQ(played.direct.rows(), static_cast<Eigen::Index>(room.samples.size()));
    EXPECT_TRUE(played.direct.isZero(0.0F));
    EXPECT_TRUE(played.indirect.isZero(0.0F));
  }
}

TEST(Evaluator, IsTheSameOnAnyNumberOfThreads) {
  const Package room = synthetic_room({.bits = 8});
  const std::vector<Light> lights{point_light({1, 2, 3}), point_light({3, 1, 1})};
  const SampleIrradiance one = play(Evaluator(room, {.threads = 1}), lights);
  const SampleIrradiance four = play(Evaluator(room, {.threads = 4}), lights);
  EXPECT_EQ(one.direct, four.direct);
  EXPECT_EQ(one.indirect, four.indirect);
  EXPECT_EQ(one.visibility, four.visibility);
}

/// Puts an occluder in front of sample `i`: every depth buffer direction within `cosine` of `axis`
/// (world) ends at `distance`.
void block(Package& room, std::uint32_t i, const Vec3f& axis, float cosine, float distance) {
  DepthVisibility& visibility = *room.visibility;
  const std::uint32_t c = room.samples.cluster_of_sample()[i];
  QuantisedMatrix& coefficients = visibility.clusters[c].coefficients;
  const HemisphereDirections directions(visibility.directions);
  for (int d = 0; d < directions.count(); ++d) {
    const Vec3f world = room.samples.frame(i) * directions.direction(d);
    if (world.dot(axis) < cosine) continue;
    const std::size_t row = i - room.samples.cluster_begin[c];
    coefficients.float32[row * coefficients.cols + static_cast<std::size_t>(d)] =
        encode_depth(distance, visibility.bound);
  }
}

TEST(Evaluator, HandMadeDepthsShadowWhatLiesBehindThem) {
  Package room = synthetic_room({.directions = 2016});
  const std::uint32_t i = 7;
  const Vec3f up = room.samples.normals[i];
  block(room, i, up, 0.8F, 1.0F);
  const Evaluator evaluator(room);
  const Vec3f base = room.samples.positions[i];
  const auto visibility = [&](const Vec3f& p) { return evaluator.visibility(point_light(p))[i]; };
  EXPECT_EQ(visibility(base + 1.5F * up), 0.0F);
  EXPECT_FLOAT_EQ(visibility(base + 1.05F * up), 1.0F);  // within the bias of 7 %
  EXPECT_FLOAT_EQ(visibility(base + 0.9F * up), 1.0F);
  const Vec3f aside = (up + 1.2F * room.samples.tangents[i]).normalized();  // cosine 0.64
  EXPECT_FLOAT_EQ(visibility(base + 1.5F * aside), 1.0F);
  EXPECT_EQ(visibility(base - 0.5F * up), kUnlit);
  // The neighbours are not concerned.
  EXPECT_FLOAT_EQ(evaluator.visibility(point_light(base + 1.5F * up))[i + 1], 1.0F);
}

TEST(Evaluator, ClustersOfRankZeroSeeTheirMean) {
  // As they are read from a file: matrices without numbers have no scales.
  Package room = synthetic_room();
  for (DepthBlock& block : room.visibility->clusters) {
    block.basis = {0, block.basis.cols, 8, {}, {}, {}, {}};
    block.coefficients = {block.coefficients.rows, 0, 8, {}, {}, {}, {}};
    std::ranges::fill(block.mean.float32, 1.0F);
  }
  const SampleIrradiance played = play(Evaluator(room), {point_light({1, 1, 1})});
  const Package open = synthetic_room({.directions = 0});
  const SampleIrradiance unshadowed = play(Evaluator(open), {point_light({1, 1, 1})});
  EXPECT_TRUE(played.direct.isApprox(unshadowed.direct, kRounding));
}

TEST(Evaluator, AtTheRimOfAnOccluderVisibilityIsBetween) {
  Package room = synthetic_room({.directions = 2016});
  const std::uint32_t i = 7;
  const Vec3f up = room.samples.normals[i];
  block(room, i, up, 0.8F, 1.0F);
  const Evaluator evaluator(room);
  float previous = 0.0F;
  int between = 0;
  for (int step = 0; step <= 100; ++step) {  // across the rim
    const float angle = 0.5F + 0.003F * static_cast<float>(step);
    const Vec3f d = std::cos(angle) * up + std::sin(angle) * room.samples.tangents[i];
    const float v = evaluator.visibility(point_light(room.samples.positions[i] + 1.5F * d))[i];
    between += v > 0.0F && v < 1.0F;
    previous = v;
  }
  EXPECT_GT(between, 5);
  EXPECT_FLOAT_EQ(previous, 1.0F);
}

TEST(Evaluator, TheSunShinesOnlyWhereRaysEscape) {
  Package room = synthetic_room();
  Light sun;
  sun.kind = Light::Kind::kSun;
  sun.direction = -Vec3f::UnitY();
  EXPECT_TRUE(play(Evaluator(room), {sun}).direct.isZero(0.0F));
  block(room, 20, Vec3f::UnitY(), -1.0F, 2.0F * room.visibility->bound);
  const SampleIrradiance played = play(Evaluator(room), {sun});
  EXPECT_FLOAT_EQ(played.direct(20, 1), 1.0F);
  EXPECT_EQ(played.direct(21, 1), 0.0F);
}

TEST(Evaluator, AreaLightsConvergeToTheirIntegral) {
  // Far below a ceiling panel facing down: radiance · area · cos · cos / r².
  const Package room = synthetic_room({.directions = 0});
  const Evaluator evaluator(room, {.area_samples = 25});
  Light quad;
  quad.kind = Light::Kind::kQuad;
  quad.position = Vec3f(2, 2.9F, 2.5F);
  quad.edge_u = Vec3f(0.2F, 0, 0);
  quad.edge_v = Vec3f(0, 0, 0.2F);  // u × v = -y
  const SampleIrradiance played = play(evaluator, {quad});
  for (std::uint32_t i = 0; i < room.samples.cluster_begin[1]; ++i) {
    const Vec3f offset = quad.position - room.samples.positions[i];
    const float cosine = offset.normalized().y();
    const float expected = 0.04F * cosine * cosine / offset.squaredNorm();
    ASSERT_NEAR(played.direct(i, 0), expected, 0.005F * expected);  // the panel is not a point
  }
}

TEST(LightSamples, AreAsManyAsAskedForAndStratified) {
  Light sphere;
  sphere.kind = Light::Kind::kSphere;
  sphere.radius = 0.1F;
  for (const int count : {1, 2, 7, 25, 64}) {
    Vec2f mean = Vec2f::Zero();
    const std::vector<Vec2f> samples = light_samples(sphere, count);
    ASSERT_EQ(samples.size(), static_cast<std::size_t>(count));
    for (const Vec2f& s : samples) {
      EXPECT_TRUE(s.x() >= 0.0F && s.x() < 1.0F && s.y() >= 0.0F && s.y() < 1.0F);
      mean += s / static_cast<float>(count);
    }
    EXPECT_NEAR(mean.x(), 0.5F, 1e-5F);
  }
  EXPECT_EQ(light_samples(Light{}, 25).size(), 1U);
}

TEST(Reconstruction, LightAtAPointUsesItsOwnDistanceAndAngle) {
  const Package room = synthetic_room({.directions = 0});
  const Evaluator evaluator(room);
  const std::vector<Light> lights{point_light({2, 1.5F, 2})};
  const SampleIrradiance irradiance = play(evaluator, lights);
  std::vector<PlayPoint> points;
  for (std::uint64_t q = 0; q < 200; ++q) {
    Random random(5, q);
    const float x = 4.0F * random.uniform();
    points.push_back({Vec3f(x, 0, 5.0F * random.uniform()), Vec3f::UnitY(), Vec3f::UnitY()});
  }
  const auto played = evaluator.reconstruct(irradiance, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(played[i].reached);
    const Vec3f offset = lights[0].position - points[i].position;
    const Vec3f expected = offset.y() / std::pow(offset.norm(), 3.0F) * lights[0].intensity;
    ASSERT_TRUE(played[i].direct.isApprox(expected, kRounding));
    // The synthetic transfer is constant, and splats keep constants.
    ASSERT_NEAR(played[i].indirect.x(), irradiance.indirect(0, 0),
                kRounding * irradiance.indirect(0, 0));
  }
}

TEST(Reconstruction, FarFromTheSurfaceNothingIsKnown) {
  const Package room = synthetic_room();
  const Evaluator evaluator(room);
  const SampleIrradiance irradiance = play(evaluator, {point_light({1, 1, 1})});
  const std::vector<PlayPoint> points{
      {room.samples.positions[0], -Vec3f::UnitY(), -Vec3f::UnitY()}};
  EXPECT_FALSE(evaluator.reconstruct(irradiance, points)[0].reached);
}

TEST(Rendering, ARoomHasNoHoles) {
  const Package room = synthetic_room();
  const Evaluator evaluator(room);
  const SampleIrradiance irradiance = play(evaluator, {point_light({2, 1.5F, 2.5F})});
  PictureSettings settings;
  settings.width = 80;
  settings.height = 60;
  for (const Show show :
       {Show::kFull, Show::kDirect, Show::kIndirect, Show::kVisibility, Show::kClusters}) {
    settings.show = show;
    const Picture picture = render(evaluator, irradiance, default_camera(evaluator), settings);
    EXPECT_EQ(picture.rgb.size(), 3U * 80U * 60U);
    EXPECT_EQ(picture.holes, 0U);
    EXPECT_EQ(picture.not_finite, 0U);
    EXPECT_EQ(picture.covered, 80U * 60U);  // the room is closed
  }
}

TEST(Rendering, OwnExposureDoesNotDependOnTheLightsPower) {
  const Package room = synthetic_room();
  const Evaluator evaluator(room);
  const SceneCamera camera = default_camera(evaluator);
  Light light = point_light({2, 1.5F, 2.5F});
  PictureSettings settings;
  settings.width = 40;
  settings.height = 30;
  const Picture dim = render(evaluator, play(evaluator, {light}), camera, settings);
  light.intensity *= 4.0F;
  const Picture bright = render(evaluator, play(evaluator, {light}), camera, settings);
  EXPECT_EQ(dim.rgb, bright.rgb);
  EXPECT_FLOAT_EQ(dim.exposure, 4.0F * bright.exposure);
}

TEST(SetUp, WithoutCameraAndLightAFreePlaceIsFound) {
  Package room = synthetic_room();
  room.scene.camera.reset();
  room.scene.lights.clear();
  const Evaluator evaluator(room);
  const SceneCamera camera = default_camera(evaluator);
  const Light light = default_light(evaluator);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float p : {camera.eye[axis], light.position[axis]}) {
      EXPECT_GT(p, 0.0F);
      EXPECT_LT(p, room.scene.bounds_max[axis]);
    }
  }
  EXPECT_GT(play(evaluator, {light}).direct.minCoeff(), 0.0F);
}

}  // namespace
}  // namespace prt
