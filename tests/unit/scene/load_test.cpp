// What a sound glTF file may hold, and what becomes of it.
#include "scene/load.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

using testing::GltfWriter;
using testing::square_file;
using testing::TemporaryFolder;
using Json = nlohmann::json;

/// Rounding of a handful of float operations on values near 1.
constexpr float kRounding = 1e-6F;
/// 8-bit texels, decoded from sRGB and interpolated in float.
constexpr float kTexel = 1e-5F;

void expect_near(const Vec3f& a, const Vec3f& b, float tolerance = kRounding) {
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance)
      << a.transpose() << " instead of " << b.transpose();
}

double total_area(const Scene& scene) {
  double area = 0.0;
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) area += triangle_area(scene, t);
  return area;
}

/// All triangles face that way, and so do their shading normals.
void expect_facing(const Scene& scene, const Vec3f& normal) {
  ASSERT_FALSE(scene.triangles.empty());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    expect_near(triangle_normal(scene, t), normal);
    for (const std::uint32_t v : scene.triangles[t].vertex) expect_near(scene.normals[v], normal);
  }
}

TEST(Load, ReadsASquare) {
  const Scene scene = square_file().load();
  EXPECT_EQ(scene.positions.size(), 4U);
  ASSERT_EQ(scene.triangles.size(), 2U);
  EXPECT_EQ(scene.triangles[1].vertex, (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(scene.uvs[2], Vec2f(1, 1));
  EXPECT_EQ(scene.bounds_max, Vec3f(1, 1, 0));
  EXPECT_EQ(scene.repairs.total(), 0U);
  EXPECT_DOUBLE_EQ(total_area(scene), 1.0);
  expect_facing(scene, Vec3f::UnitZ());
  ASSERT_EQ(scene.materials.size(), 1U) << "the default material";
  EXPECT_EQ(albedo_at(scene, 0, 0.2F, 0.3F), Vec3f::Ones());
}

TEST(Load, KeepsTheFrontOfMirroredNodes) {
  expect_facing(square_file({{"scale", {-1, 1, 1}}}).load(), Vec3f::UnitZ());
  expect_facing(square_file({{"scale", {1, 1, -1}}}).load(), -Vec3f::UnitZ());
  expect_facing(square_file({{"scale", {-2, -3, -4}}}).load(), -Vec3f::UnitZ());
}

TEST(Load, TransformsByTranslationRotationScale) {
  // A quarter turn about x takes y to z and z to -y.
  const double h = std::numbers::sqrt2 / 2.0;
  const Scene scene =
      square_file({{"translation", {5, 6, 7}}, {"rotation", {h, 0, 0, h}}, {"scale", {2, 3, 4}}})
          .load();
  expect_near(scene.positions[2], Vec3f(7, 6, 10), 8 * kRounding);
  expect_facing(scene, -Vec3f::UnitY());
}

TEST(Load, KeepsNormalsPerpendicularUnderShear) {
  // x' = x + 2z: the plane x = 0 becomes x = 2z, with normal (1, 0, -2).
  GltfWriter writer;
  writer.add_accessor(std::vector<float>{0, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
  writer.add_accessor(std::vector<float>{1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3");
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}},
                       {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1}}});
  expect_facing(writer.load(), Vec3f(1, 0, -2).normalized());
}

TEST(Load, MultipliesTransformsDownTheTree) {
  GltfWriter writer = square_file({{"translation", {1, 0, 0}}});
  writer.json["nodes"].push_back({{"children", {0}}, {"scale", {2, 2, 2}}});
  writer.json["scenes"][0]["nodes"] = {1};
  expect_near(writer.load().positions[0], Vec3f(2, 0, 0));
}

TEST(Load, ReadsInstancesAsSurfacesOfTheirOwn) {
  GltfWriter writer = square_file();
  writer.add_node({{"mesh", 0}, {"translation", {0, 0, 5}}});
  const Scene scene = writer.load();
  ASSERT_EQ(scene.triangles.size(), 4U);
  EXPECT_EQ(scene.triangles[1].surface, 0U);
  EXPECT_EQ(scene.triangles[2].surface, 1U);
  EXPECT_EQ(scene.positions[4].z(), 5.0F);
}

TEST(Load, TakesTheDefaultSceneOnly) {
  GltfWriter writer = square_file();
  writer.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 5}}});
  writer.json["scenes"].push_back({{"nodes", {1}}});
  writer.json["scene"] = 1;
  const Scene scene = writer.load();
  EXPECT_EQ(scene.triangles.size(), 2U);
  EXPECT_EQ(scene.positions[0].z(), 5.0F);
  writer.json.erase("scene");
  EXPECT_EQ(writer.load().positions[0].z(), 0.0F) << "the first scene";
  writer.json.erase("scenes");
  EXPECT_EQ(writer.load().triangles.size(), 4U) << "all roots";
}

TEST(Load, ReadsStripsFansAndBareVertices) {
  const std::vector<float> zigzag = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
  GltfWriter strip;
  strip.add_accessor(zigzag, "VEC3");
  strip.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"mode", 5}});
  expect_facing(strip.load(), Vec3f::UnitZ());
  EXPECT_DOUBLE_EQ(total_area(strip.load()), 1.5);

  GltfWriter fan;
  fan.add_accessor(testing::kSquare, "VEC3");
  fan.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"mode", 6}});
  expect_facing(fan.load(), Vec3f::UnitZ());
  EXPECT_DOUBLE_EQ(total_area(fan.load()), 1.0);

  GltfWriter bare;
  bare.add_accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  bare.add_mesh_node({{"attributes", {{"POSITION", 0}}}});
  expect_facing(bare.load(), Vec3f::UnitZ());
  EXPECT_EQ(bare.load().repairs.missing_normals, 1U);
}

template <typename Index>
Digest hash_with_indices() {
  GltfWriter writer = square_file();
  std::vector<Index> indices(testing::kSquareIndices.begin(), testing::kSquareIndices.end());
  writer.json["meshes"][0]["primitives"][0]["indices"] = writer.add_accessor(indices, "SCALAR");
  return writer.load().geometry_hash;
}

TEST(Load, ReadsAllIndexTypes) {
  const Digest expected = square_file().load().geometry_hash;
  EXPECT_EQ(hash_with_indices<std::uint8_t>(), expected);
  EXPECT_EQ(hash_with_indices<std::uint16_t>(), expected);
  EXPECT_EQ(hash_with_indices<std::uint32_t>(), expected);
}

TEST(Load, SkipsPointsAndLines) {
  GltfWriter writer = square_file();
  for (int mode = 0; mode < 4; ++mode) {
    writer.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  }
  const Scene scene = writer.load();
  EXPECT_EQ(scene.triangles.size(), 2U);
  EXPECT_EQ(scene.repairs.skipped_primitives, 4U);
}

TEST(Load, ReplacesBadNormals) {
  GltfWriter writer = square_file();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  writer.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      writer.add_accessor(std::vector<float>{0, 0, 0, nan, 0, 0, 0, 0, 1, 0, 0, 5}, "VEC3");
  const Scene scene = writer.load();
  EXPECT_EQ(scene.repairs.bad_normals, 2U);
  expect_facing(scene, Vec3f::UnitZ());
}

TEST(Load, LeavesOutWhatHasNoArea) {
  GltfWriter writer = square_file();
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> positions = {0, 0, 0, 1, 0,   0, 2, 0, 0, 0,    1,
                                        0, 0, 0, 0, inf, 0, 0, 1, 0, 1e-7F};
  writer.json["meshes"][0]["primitives"][0] = {
      {"attributes", {{"POSITION", writer.add_accessor(positions, "VEC3")}}},
      {"indices", writer.add_accessor(std::vector<std::uint8_t>{0, 1, 3,   // sound
                                                                0, 1, 1,   // a vertex twice
                                                                0, 1, 2,   // in a line
                                                                0, 3, 4,   // a position twice
                                                                0, 2, 6,   // thinner than float
                                                                0, 1, 5},  // infinite
                                      "SCALAR")}};
  const Scene scene = writer.load();
  EXPECT_EQ(scene.triangles.size(), 1U);
  EXPECT_EQ(scene.repairs.degenerate_triangles, 4U);
  EXPECT_EQ(scene.repairs.non_finite_triangles, 1U);
  EXPECT_EQ(scene.bounds_max, Vec3f(1, 1, 0)) << "nothing of what was left out remains";
}

TEST(Load, KeepsSmallAndThinTriangles) {
  GltfWriter writer;
  writer.add_accessor(std::vector<float>{0, 0, 0, 1e-6F, 0, 0, 0, 1e-6F, 0,  // tiny
                                         0, 0, 0, 1, 0, 0, 1, 1e-5F, 0},     // needle
                      "VEC3");
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}}}});
  const Scene scene = writer.load();
  EXPECT_EQ(scene.triangles.size(), 2U);
  expect_facing(scene, Vec3f::UnitZ());
}

TEST(Load, LeavesOutFlatteningNodes) {
  GltfWriter writer = square_file();
  writer.add_node({{"mesh", 0}, {"scale", {1, 1, 0}}});
  writer.add_node({{"mesh", 0}, {"scale", {1e-3, 1e-3, 1e3}}});
  const Scene scene = writer.load();
  EXPECT_EQ(scene.repairs.singular_transforms, 1U);
  EXPECT_EQ(scene.triangles.size(), 4U);
}

TEST(Load, MakesNormalsFlatWhereMissing) {
  // Two faces of a roof share an edge; smooth normals would lean on both.
  GltfWriter writer;
  writer.add_accessor(std::vector<float>{0, 0, 0, 0, 1, 0, -1, 0, -1, 1, 0, -1}, "VEC3");
  writer.add_accessor(std::vector<std::uint8_t>{0, 1, 2, 1, 0, 3}, "SCALAR");
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  const Scene scene = writer.load();
  EXPECT_EQ(scene.positions.size(), 6U);
  for (std::uint32_t t = 0; t < 2; ++t) {
    for (const auto v : scene.triangles[t].vertex) {
      expect_near(scene.normals[v], triangle_normal(scene, t));
    }
  }
}

TEST(Load, ReadsQuantisedAttributes) {
  GltfWriter writer;
  writer.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  // Normalised shorts in steps of eight bytes.
  const std::vector<std::int16_t> positions = {0,     0,     0, 0, 32767, 0,     0, 0,
                                               32767, 32767, 0, 0, 0,     32767, 0, 0};
  writer.add_accessor(positions, "VEC4");
  writer.json["accessors"][0].update({{"type", "VEC3"}, {"normalized", true}});
  writer.json["bufferViews"][0]["byteStride"] = 8;
  writer.add_accessor(
      std::vector<std::int8_t>{0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, "VEC4");
  writer.json["accessors"][1].update({{"type", "VEC3"}, {"normalized", true}});
  writer.json["bufferViews"][1]["byteStride"] = 4;
  writer.add_accessor(testing::kSquareIndices, "SCALAR");
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}});
  const Scene scene = writer.load();
  expect_near(scene.positions[2], Vec3f(1, 1, 0));
  expect_facing(scene, Vec3f::UnitZ());
}

/// A PNG of one pixel with 16 bits per channel: 0x1234, 0x80ff, 0xff00, 0xffff.
const std::vector<std::uint8_t> kWidePng = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
    0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x10, 0x06, 0x00, 0x00, 0x00, 0x4f,
    0x85, 0x18, 0xca, 0x00, 0x00, 0x00, 0x11, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x10,
    0x32, 0x69, 0xf8, 0xff, 0x9f, 0xe1, 0xff, 0x7f, 0x00, 0x10, 0xf9, 0x04, 0xc3, 0x65, 0x99,
    0x07, 0x50, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

TEST(Load, KeepsTheHighByteOfWideImages) {
  GltfWriter writer = square_file();
  testing::set_texture(writer, std::string(kWidePng.begin(), kWidePng.end()));
  const Scene scene = writer.load();
  ASSERT_EQ(scene.textures.size(), 1U);
  EXPECT_EQ(scene.textures[0].rgba, (std::vector<std::uint8_t>{0x12, 0x80, 0xff, 0xff}));
  EXPECT_EQ(scene.textures[0].encoded.size(), kWidePng.size());
}

TEST(Load, ReadsNoImageThatIsNoBaseColour) {
  GltfWriter writer = square_file();
  writer.json["images"] = {{{"uri", "not_there.png"}}};
  writer.json["textures"] = {{{"source", 0}}};
  writer.json["materials"] = {{{"normalTexture", {{"index", 0}}}}};
  EXPECT_EQ(writer.load().textures.size(), 0U);
}

TEST(Load, ReadsSparseAccessors) {
  GltfWriter writer = square_file();
  const std::size_t indices = writer.add_view(GltfWriter::bytes_of<std::uint16_t>({2}));
  const std::size_t values = writer.add_view(GltfWriter::bytes_of<float>({3, 3, 0}));
  writer.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
      {"values", {{"bufferView", values}}}};
  const Scene scene = writer.load();
  EXPECT_EQ(scene.positions[1], Vec3f(1, 0, 0));
  EXPECT_EQ(scene.positions[2], Vec3f(3, 3, 0));
}

TEST(Load, ReadsTextFilesWithTheirBuffers) {
  const GltfWriter writer = square_file();
  const Digest expected = writer.load().geometry_hash;
  const TemporaryFolder folder;
  folder.write("data/some buffer.bin", writer.binary);
  EXPECT_EQ(load_scene(folder.write("a.gltf", writer.gltf("data/some%20buffer.bin"))).geometry_hash,
            expected);
  const std::string data = "data:application/octet-stream;base64," + testing::base64(writer.binary);
  EXPECT_EQ(load_scene(folder.write("b.gltf", writer.gltf(data))).geometry_hash, expected);
}

TEST(Load, MultipliesBaseColourAndTexture) {
  GltfWriter writer = square_file();
  // sRGB 188 is 0.502886 linear (IEC 61966-2-1).
  testing::set_texture(writer, testing::png(1, 1, {188, 255, 0, 255}));
  writer.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 2.0, 1.0, 1.0};
  const Scene scene = writer.load();
  expect_near(albedo_at(scene, 0, 0.3F, 0.3F), Vec3f(0.5F * 0.502886F, 1, 0), kTexel);
  EXPECT_EQ(scene.repairs.clamped_albedos, 1U);
  EXPECT_EQ(scene.textures[0].mime_type, "image/png");
  EXPECT_EQ(scene.textures[0].encoded.size(), testing::png(1, 1, {188, 255, 0, 255}).size());
}

TEST(Load, ReadsJpegs) {
  GltfWriter writer = square_file();
  testing::set_texture(writer, testing::jpeg(8, 8, std::vector<std::uint8_t>(256, 188)));
  const Scene scene = writer.load();
  // JPEG rounds by a few levels, of which one is 0.007 here.
  expect_near(albedo_at(scene, 0, 0.3F, 0.3F), Vec3f::Constant(0.502886F), 0.03F);
  EXPECT_EQ(scene.textures[0].mime_type, "image/jpeg");
}

TEST(Load, AppliesTextureTransforms) {
  GltfWriter writer = square_file();
  testing::set_texture(writer, testing::png(1, 1, {255, 255, 255, 255}));
  writer.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {
      {"KHR_texture_transform",
       {{"offset", {0.25, 0.5}}, {"rotation", std::numbers::pi / 2.0}, {"scale", {2, 3}}}}};
  const Scene scene = writer.load();
  // The extension's own matrices: T(offset) · [[cos, sin], [-sin, cos]] · S(scale).
  EXPECT_LE((scene.uvs[1] - Vec2f(0.25F, 0.5F - 2.0F)).norm(), kRounding);
  EXPECT_LE((scene.uvs[3] - Vec2f(0.25F + 3.0F, 0.5F)).norm(), kRounding);
}

TEST(Load, NotesWhatItIgnores) {
  GltfWriter writer = square_file();
  writer.append("materials", {{"alphaMode", "BLEND"}, {"emissiveFactor", {1, 1, 1}}});
  writer.append("materials", {{"extensions", {{"KHR_materials_unlit", Json::object()}}}});
  const Scene scene = writer.load();
  EXPECT_FALSE(scene.materials[0].alpha_mask);
  EXPECT_EQ(scene.repairs.notes.size(), 3U);
}

TEST(Load, OffersLightsAndCameraInWatts) {
  GltfWriter writer = square_file();
  writer.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", 683.0}, {"color", {1, 0.5, 0}}},
      {{"type", "spot"}, {"intensity", 1366.0}, {"spot", {{"outerConeAngle", 0.5}}}},
      {{"type", "directional"}, {"intensity", 68.3}}};
  writer.append("cameras",
                {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  const double h = std::numbers::sqrt2 / 2.0;
  const auto holder = [](int light) { return Json{{"KHR_lights_punctual", {{"light", light}}}}; };
  writer.add_node({{"extensions", holder(0)}, {"translation", {1, 2, 3}}});
  writer.add_node({{"extensions", holder(1)}, {"rotation", {-h, 0, 0, h}}, {"scale", {2, 2, 2}}});
  writer.add_node({{"extensions", holder(2)}});
  writer.add_node({{"camera", 0}, {"translation", {0, 1, 4}}});
  const Scene scene = writer.load();
  ASSERT_EQ(scene.lights.size(), 3U);
  EXPECT_EQ(scene.lights[0].kind, SceneLight::Kind::kPoint);
  expect_near(scene.lights[0].intensity, Vec3f(1, 0.5F, 0));
  expect_near(scene.lights[0].position, Vec3f(1, 2, 3));
  EXPECT_EQ(scene.lights[1].kind, SceneLight::Kind::kSpot);
  expect_near(scene.lights[1].direction, -Vec3f::UnitY());
  EXPECT_FLOAT_EQ(scene.lights[1].outer_angle, 0.5F);
  expect_near(scene.lights[1].intensity, Vec3f::Constant(2));
  EXPECT_EQ(scene.lights[2].kind, SceneLight::Kind::kSun);
  expect_near(scene.lights[2].intensity, Vec3f::Constant(0.1F));
  ASSERT_TRUE(scene.camera.has_value());
  expect_near(scene.camera->eye, Vec3f(0, 1, 4));
  expect_near((scene.camera->target - scene.camera->eye).normalized(), -Vec3f::UnitZ());
  EXPECT_FLOAT_EQ(scene.camera->vertical_fov, 0.7F);
}

TEST(Load, HashesGeometryMaterialsAndLightsApart) {
  GltfWriter writer = square_file();
  testing::set_texture(writer, testing::png(2, 1, {10, 20, 30, 255, 40, 50, 60, 0}));
  writer.json["materials"][0]["alphaMode"] = "MASK";
  writer.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  writer.add_node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  const Scene scene = writer.load();
  const auto changed = [&](const std::function<void(GltfWriter&)>& change) {
    GltfWriter other = writer;
    change(other);
    const Scene s = other.load();
    return std::string(s.geometry_hash != scene.geometry_hash ? "G" : "") +
           (s.materials_hash != scene.materials_hash ? "M" : "") +
           (s.lights_hash != scene.lights_hash ? "L" : "");
  };
  EXPECT_EQ(changed([](GltfWriter&) {}), "");
  EXPECT_EQ(changed([](GltfWriter& w) {
              w.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.1, 1, 1, 1};
            }),
            "M");
  EXPECT_EQ(changed([](GltfWriter& w) {
              testing::set_texture(w, testing::png(2, 1, {99, 20, 30, 255, 40, 50, 60, 0}));
            }),
            "M");
  EXPECT_EQ(changed([](GltfWriter& w) {
              testing::set_texture(w, testing::png(2, 1, {10, 20, 30, 255, 40, 50, 60, 9}));
            }),
            "GM");
  EXPECT_EQ(changed([](GltfWriter& w) { w.json["materials"][0]["alphaCutoff"] = 0.4; }), "GM");
  EXPECT_EQ(changed([](GltfWriter& w) { w.json["nodes"][0]["scale"] = {1, 1, 2}; }), "");
  EXPECT_EQ(changed([](GltfWriter& w) { w.json["nodes"][0]["scale"] = {1, 2, 1}; }), "G");
  EXPECT_EQ(changed([](GltfWriter& w) { w.json["nodes"][1]["translation"] = {1, 2, 1}; }), "L");
}

TEST(Load, ReadsDeepTrees) {
  constexpr int kDepth = 50'000;  // far beyond what recursion would bear
  GltfWriter writer = square_file();
  for (int i = 1; i < kDepth; ++i) writer.json["nodes"].push_back({{"children", {i - 1}}});
  writer.json["scenes"][0]["nodes"] = {kDepth - 1};
  EXPECT_EQ(writer.load().triangles.size(), 2U);
}

}  // namespace
}  // namespace prt
