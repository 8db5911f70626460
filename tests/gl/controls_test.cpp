#include "player/gl/controls.h"

#include <gtest/gtest.h>

#include "player/gl/eyes.h"
#include "player/view.h"

namespace prt {
namespace {

constexpr float kRounding = 1e-4F;
constexpr int kHeight = 600;

const SceneCamera kCamera{.eye = {1, 2, 5}, .target = {0, 1, 0}, .vertical_fov = 1.0F};

/// Pixels from the middle of an image, x to the right, y down.
Vec2f pixel_of(const Vec3f& p, const SceneCamera& camera) {
  const Projected at = View(camera, kHeight, kHeight).project(p);
  return Vec2f(float(at.x / at.w), float(at.y / at.w)) * kHeight / 2;
}

TEST(Controls, LightStaysBelowThePointer) {
  const Light light{.position = {0.4F, 0.7F, 1.0F}};
  const gl::Drag drag{80, -45};
  const Light moved = gl::dragged(light, drag, false, kCamera, kHeight);
  const Vec2f way = pixel_of(moved.position, kCamera) - pixel_of(light.position, kCamera);
  EXPECT_NEAR(way.x(), drag.x, 0.01F);
  EXPECT_NEAR(way.y(), drag.y, 0.01F);
  const Light deeper = gl::dragged(light, {0, -45}, true, kCamera, kHeight);
  EXPECT_GT((deeper.position - kCamera.eye).norm(), (light.position - kCamera.eye).norm());
}

TEST(Controls, OrbitKeepsDistanceAndNeverPassesThePoles) {
  SceneCamera camera = kCamera;
  const float distance = (camera.eye - camera.target).norm();
  for (int k = 0; k < 50; ++k) {
    camera = gl::orbited(camera, {17, 40});
    EXPECT_NEAR((camera.eye - camera.target).norm(), distance, 50 * kRounding);
    EXPECT_GT((camera.eye - camera.target).cross(camera.up).norm(), 0.01F);
  }
  EXPECT_EQ(camera.target, kCamera.target);
  const SceneCamera turned = gl::turned(kCamera, {30, -20});
  EXPECT_EQ(turned.eye, kCamera.eye);
  EXPECT_NE(turned.target, kCamera.target);
  const SceneCamera round = gl::turntable(kCamera, 1.0F);
  EXPECT_LT((round.eye - kCamera.eye).norm(), 50 * kRounding);
}

TEST(Controls, AnotherKindOfLightIsAboutAsBright) {
  const Light point{.position = {0, 1, 0}, .intensity = {8, 6, 4}};
  constexpr float kSize = 10.0F;
  const Vec3f below(0, 1 - 0.2F * kSize, 0);
  const auto irradiance = [&](const Light& light) {
    return incident_light(light, below, 0.5F, 0.5F).irradiance;
  };
  for (const auto kind :
       {Light::Kind::kSphere, Light::Kind::kSpot, Light::Kind::kQuad, Light::Kind::kSun}) {
    const Light other = gl::as_kind(point, kind, kSize);
    EXPECT_EQ(other.kind, kind);
    EXPECT_LT((irradiance(other) - irradiance(point)).norm(), 0.1F * irradiance(point).norm());
    const Light back = gl::as_kind(other, Light::Kind::kPoint, kSize);
    EXPECT_LT((back.intensity - point.intensity).norm(), kRounding * point.intensity.norm());
  }
}

TEST(Controls, EyesStandApartAndLookTheSameWay) {
  const auto eyes = gl::eye_cameras(kCamera, {.on = true, .eye_distance = 0.07F});
  ASSERT_EQ(eyes.size(), 2U);
  EXPECT_NEAR((eyes[1].eye - eyes[0].eye).norm(), 0.07F, kRounding);
  EXPECT_LT(pixel_of(eyes[0].eye + (eyes[0].target - eyes[0].eye), kCamera).x(), 0.0F);
  for (const SceneCamera& eye : eyes) {
    EXPECT_LT(((eye.target - eye.eye) - (kCamera.target - kCamera.eye)).norm(), kRounding);
  }
  EXPECT_EQ(gl::eye_cameras(kCamera, {}).front().eye, kCamera.eye);
}

}  // namespace
}  // namespace prt
