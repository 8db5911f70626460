// Points, normals, albedo and alpha on triangles.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "scene/scene.h"

namespace prt {
namespace {

constexpr float kRounding = 1e-6F;

Scene one_triangle() {
  Scene scene;
  scene.positions = {Vec3f(0, 0, 0), Vec3f(2, 0, 0), Vec3f(0, 2, 0)};
  scene.normals.assign(3, Vec3f::UnitZ());
  scene.uvs = {Vec2f(0, 0), Vec2f(2, 0), Vec2f(0, 2)};
  scene.triangles = {{{0, 1, 2}, 0, 0}};
  scene.materials.resize(1);
  scene.bounds_max = {2, 2, 0};
  return scene;
}

/// Four by one texels: red 0, 255, 0, 0; alpha 255, 0, 255, 255.
void add_texture(Scene& scene, Texture::Wrap wrap) {
  Texture& texture = scene.textures.emplace_back();
  texture.width = 4;
  texture.height = 1;
  texture.rgba = {0, 9, 9, 255, 255, 9, 9, 0, 0, 9, 9, 255, 0, 9, 9, 255};
  texture.wrap_u = wrap;
  scene.materials[0].texture = 0;
}

/// Red at texture coordinate x.
float red_at(const Scene& scene, float x) { return albedo_at(scene, 0, x / 2.0F, 0).x(); }

TEST(Surface, FacesAgainstTheRay) {
  const Scene scene = one_triangle();
  const Hit hit{0, 1, 0.25F, 0.5F};
  const SurfacePoint above = surface_at(scene, {Vec3f(0.5F, 1, 1), -Vec3f::UnitZ()}, hit);
  EXPECT_EQ(above.position, Vec3f(0.5F, 1, 0));
  EXPECT_EQ(above.normal, Vec3f::UnitZ());
  EXPECT_TRUE(above.front);
  const SurfacePoint below = surface_at(scene, {Vec3f(0.5F, 1, -1), Vec3f::UnitZ()}, hit);
  EXPECT_EQ(below.normal, -Vec3f::UnitZ());
  EXPECT_FALSE(below.front);
  EXPECT_DOUBLE_EQ(triangle_area(scene, 0), 2.0);
}

TEST(Surface, NormalsOfNeedlesAreExact) {
  Scene scene = one_triangle();
  scene.positions = {Vec3f(1000, 1, 5), Vec3f(1001, 1, 5), Vec3f(1000.5F, 1.000001F, 5)};
  EXPECT_LE((triangle_normal(scene, 0) - Vec3f::UnitZ()).norm(), kRounding);
}

TEST(Surface, InterpolatesTexelsBetweenTheirCentres) {
  Scene scene = one_triangle();
  add_texture(scene, Texture::Wrap::kRepeat);
  EXPECT_NEAR(red_at(scene, 0.375F), 1.0F, kRounding) << "centre of texel 1";
  EXPECT_NEAR(red_at(scene, 0.25F), 0.5F, kRounding) << "linear light, not sRGB, is averaged";
  EXPECT_NEAR(red_at(scene, 0.4375F), 0.75F, kRounding);
  EXPECT_NEAR(red_at(scene, 0.875F), 0.0F, kRounding);
  scene.materials[0].base_color = {0.5F, 1, 1};
  EXPECT_NEAR(red_at(scene, 0.375F), 0.5F, kRounding);
}

TEST(Surface, WrapsTextures) {
  Scene repeat = one_triangle();
  add_texture(repeat, Texture::Wrap::kRepeat);
  Scene mirror = one_triangle();
  add_texture(mirror, Texture::Wrap::kMirror);
  Scene clamp = one_triangle();
  add_texture(clamp, Texture::Wrap::kClamp);
  clamp.textures[0].rgba[12] = 255;  // the last texel
  EXPECT_NEAR(red_at(repeat, 1.375F), 1.0F, kRounding);
  EXPECT_NEAR(red_at(repeat, -0.625F), 1.0F, kRounding);
  EXPECT_NEAR(red_at(repeat, 1000.375F), 1.0F, 1e-3F);
  EXPECT_NEAR(red_at(mirror, 1.375F), 0.0F, kRounding);
  EXPECT_NEAR(red_at(mirror, 1.625F), 1.0F, kRounding);
  EXPECT_NEAR(red_at(mirror, -0.375F), 1.0F, kRounding);
  EXPECT_NEAR(red_at(clamp, 1.7F), 1.0F, kRounding);
  EXPECT_NEAR(red_at(clamp, 1e30F), 1.0F, kRounding);
  EXPECT_NEAR(red_at(clamp, -1e30F), 0.0F, kRounding);
  EXPECT_TRUE(std::isfinite(red_at(repeat, 1e30F)));
  EXPECT_TRUE(std::isfinite(red_at(mirror, -1e30F)));
}

TEST(Surface, ExistsWhereAlphaReachesTheCutoff) {
  Scene scene = one_triangle();
  add_texture(scene, Texture::Wrap::kRepeat);
  const auto there = [&](float x) { return opaque_at(scene, 0, x / 2.0F, 0); };
  EXPECT_TRUE(there(0.375F)) << "no mask, no hole";
  scene.materials[0].alpha_mask = true;
  EXPECT_FALSE(there(0.375F));
  EXPECT_TRUE(there(0.125F));
  EXPECT_TRUE(there(0.24F)) << "alpha 0.54";
  EXPECT_FALSE(there(0.26F)) << "alpha 0.46";
  scene.materials[0].alpha_cutoff = 0.4F;
  EXPECT_TRUE(there(0.26F));
  scene.materials[0].base_alpha = 0.3F;
  EXPECT_FALSE(there(0.125F));
}

TEST(Surface, OffsetsScaleWithTheScene) {
  for (const float scale : {1e-3F, 1.0F, 1e4F}) {
    Scene scene = one_triangle();
    scene.bounds_max *= scale;
    for (const Vec3f& p : {Vec3f(0, 0, 0), Vec3f(1, 1, 0), Vec3f(2, 0.3F, 0)}) {
      const float offset = offset_origin(scene, scale * p, Vec3f::UnitZ()).z() / scale;
      EXPECT_GT(offset, 1e-6F);
      EXPECT_LT(offset, 1e-4F);
    }
  }
  // Far from the origin it must still be several float spacings (here 2^-7).
  Scene far = one_triangle();
  far.bounds_min = Vec3f::Constant(1e5F);
  far.bounds_max = Vec3f::Constant(1e5F + 2.0F);
  const Vec3f p = Vec3f::Constant(1e5F + 1.0F);
  EXPECT_GE(offset_origin(far, p, Vec3f::UnitZ()).z() - p.z(), 4 * 0x1p-7F);
}

}  // namespace
}  // namespace prt
