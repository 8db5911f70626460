// Scenes that lie far from the world's origin: where float is coarse, they get an origin of their
// own before anything is rounded.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "scene/load.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

using testing::GltfWriter;
using testing::kSquare;
using testing::square_file;
using testing::TemporaryFolder;
using Json = nlohmann::json;

/// A turned square with a camera and a lamp, below one root with that translation.
GltfWriter furnished(const Vec3d& move) {
  GltfWriter writer =
      square_file({{"translation", {0.1, 0.2, 0.3}}, {"rotation", {0.1, 0.2, 0.3, 0.9}}});
  writer.append("cameras",
                {{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.01}}}});
  writer.json["extensionsUsed"] = {"KHR_lights_punctual"};
  writer.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  writer.append("nodes", {{"camera", 0}, {"translation", {0.7, 0.1, 1.9}}});
  writer.append("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                          {"translation", {0.3, 0.9, 0.1}}});
  writer.json["scenes"][0]["nodes"] = {writer.append(
      "nodes", {{"translation", {move.x(), move.y(), move.z()}}, {"children", {0, 1, 2}}})};
  return writer;
}

/// The square with its vertices stored that far from the mesh's origin.
GltfWriter stored_at(float x, Json node = Json::object()) {
  std::vector<float> positions = kSquare;
  for (std::size_t i = 0; i < positions.size(); i += 3) positions[i] += x;
  GltfWriter writer;
  writer.add_accessor(positions, "VEC3");
  writer.add_accessor(testing::kSquareIndices, "SCALAR");
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"indices", 1}}, std::move(node));
  return writer;
}

bool notes_contain(const Scene& scene, const std::string& text) {
  for (const std::string& note : scene.repairs.notes) {
    if (note.find(text) != std::string::npos) return true;
  }
  return false;
}

TEST(FarScene, OrdinaryScenesStayWhereTheyAre) {
  // The square's diagonal is 1.4 m: 20 m are 14 of them.
  for (const double x : {-20.0, 0.0, 20.0}) {
    const Scene scene = square_file({{"translation", {x, 0, 0}}}).load();
    EXPECT_EQ(scene.origin, Vec3d::Zero());
    EXPECT_EQ(scene.positions[0].x(), static_cast<float>(x));
    EXPECT_TRUE(scene.repairs.notes.empty()) << scene.repairs.notes[0];
  }
}

TEST(FarScene, MovedThroughANodeItIsTheSameScene) {
  const Scene home = furnished(Vec3d::Zero()).load();
  ASSERT_EQ(home.origin, Vec3d::Zero());
  // Multiples of four metres, the step of the origins of a scene of 1.4 m.
  for (const Vec3d& move : {Vec3d(0x1p17, -0x1p16, 0), Vec3d(1e5, 1e5, -1e5), Vec3d(0, 1e12, 0)}) {
    const Scene far = furnished(move).load();
    EXPECT_EQ(far.origin, move);
    EXPECT_EQ(far.geometry_hash, home.geometry_hash);
    EXPECT_EQ(far.materials_hash, home.materials_hash);
    EXPECT_EQ(far.lights_hash, home.lights_hash) << "and the camera";
    EXPECT_TRUE(notes_contain(far, "positions are kept relative to"));
    EXPECT_FALSE(notes_contain(far, "good to"));
    EXPECT_EQ(far.repairs.total(), 0U) << "nothing had to be mended";
  }
}

TEST(FarScene, MovedByAnyLengthItIsTheSameButForRounding) {
  const Scene home = furnished(Vec3d::Zero()).load();
  const Vec3d move(123456.789, -98765.4321, 55555.5);
  const Scene far = furnished(move).load();
  ASSERT_EQ(far.positions.size(), home.positions.size());
  // All coordinates lie below 8 m, where floats are 2^-21 m apart or closer.
  constexpr double kRounding = 0x1p-21;
  for (std::size_t i = 0; i < home.positions.size(); ++i) {
    const Vec3d world = far.origin + far.positions[i].cast<double>();
    EXPECT_LE((world - move - home.positions[i].cast<double>()).cwiseAbs().maxCoeff(), kRounding);
  }
  EXPECT_LE((far.origin + far.camera->eye.cast<double>() - move - Vec3d(0.7, 0.1, 1.9)).norm(),
            2.0 * kRounding);
  EXPECT_LE(
      (far.origin + far.lights[0].position.cast<double>() - move - Vec3d(0.3, 0.9, 0.1)).norm(),
      2.0 * kRounding);
}

TEST(FarScene, EveryNodeMayBeTheOneThatMoves) {
  GltfWriter writer = square_file({{"translation", {0.1, 0, 0}}});
  writer.json["nodes"].push_back({{"children", {0}}, {"translation", {0x1p20, 0, 0}}});
  writer.json["nodes"].push_back({{"children", {1}}, {"scale", {2, 2, 2}}});
  writer.json["scenes"][0]["nodes"] = {2};
  const Scene far = writer.load();
  writer.json["nodes"][1].erase("translation");
  EXPECT_EQ(far.origin, Vec3d(0x1p21, 0, 0));
  EXPECT_EQ(far.geometry_hash, writer.load().geometry_hash);
}

TEST(FarScene, VerticesStoredFarOutKeepWhatTheFileHas) {
  const Scene scene = stored_at(1e5F).load();
  for (std::size_t i = 0; i < scene.positions.size(); ++i) {
    const double world = scene.origin.x() + scene.positions[i].x();
    EXPECT_TRUE(world == 1e5 || world == 100001.0) << world;
  }
  EXPECT_EQ(scene.vertex_rounding, 0x1p-8) << "half of 2^-7 m";
  EXPECT_TRUE(notes_contain(scene, "vertices lie 1e+05 m from the origin of their own mesh"));
  EXPECT_TRUE(notes_contain(scene, "good to 3.9 mm")) << scene.repairs.notes.back();
  // In metres of the world, wherever the node puts them.
  const Scene half =
      stored_at(1e5F, {{"scale", {0.5, 0.5, 0.5}}, {"translation", {-5e4, 0, 0}}}).load();
  EXPECT_EQ(half.origin, Vec3d::Zero());
  EXPECT_EQ(half.vertex_rounding, 0x1p-9);
  EXPECT_TRUE(notes_contain(half, "good to 2 mm")) << half.repairs.notes.back();
}

TEST(FarScene, IntegersAreAsFineFarOutAsAnywhere) {
  GltfWriter writer;
  std::vector<std::uint16_t> corners = {60000, 0, 0, 60001, 0, 0, 60001, 1, 0, 60000, 1, 0};
  writer.add_accessor(corners, "VEC3");
  writer.add_accessor(testing::kSquareIndices, "SCALAR");
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  const Scene scene = writer.load();
  EXPECT_EQ(scene.vertex_rounding, 0.0);
  EXPECT_FALSE(notes_contain(scene, "good to"));
  EXPECT_TRUE(scene.recentred());
}

TEST(FarScene, OnlyTrianglesCount) {
  // Vertices of no triangle, triangles without area, nodes that flatten and primitives of points
  // lie near the origin.
  GltfWriter writer = stored_at(1e5F);
  std::vector<float> positions = kSquare;
  for (std::size_t i = 0; i < positions.size(); i += 3) positions[i] += 1e5F;
  positions.insert(positions.end(), {0, 0, 0});
  const auto more = writer.add_accessor(positions, "VEC3");
  writer.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = more;
  std::vector<std::uint32_t> corners(testing::kSquareIndices.begin(),
                                     testing::kSquareIndices.end());
  corners.insert(corners.end(), {4, 4, 4});
  writer.json["meshes"][0]["primitives"][0]["indices"] = writer.add_accessor(corners, "SCALAR");
  writer.add_node({{"mesh", 0}, {"scale", {0, 1, 1}}});
  const auto near = writer.add_accessor(kSquare, "VEC3");
  writer.add_mesh_node({{"attributes", {{"POSITION", near}}}, {"mode", 0}});
  EXPECT_EQ(writer.load().origin, Vec3d(100000, 0, 0));
}

TEST(FarScene, TakesAnOriginThatIsGiven) {
  const TemporaryFolder folder;
  const auto file = folder.write("scene.glb", furnished(Vec3d(1e5, 0, 0)).glb());
  const Vec3d origin(99999.5, 0.25, 0);
  const Scene scene = load_scene_about(file, origin);
  EXPECT_EQ(scene.origin, origin);
  EXPECT_EQ(scene.geometry_hash, furnished(Vec3d(0.5, -0.25, 0)).load().geometry_hash);
  EXPECT_EQ(load_scene_about(file, Vec3d::Zero()).origin, Vec3d::Zero());
}

TEST(FarScene, ExtremeExtentsEndInASceneOrAReason) {
  // So thin that its origin's step is next to nothing.
  GltfWriter thin;
  thin.add_accessor(std::vector<float>{1e14F, 0, 0, 1e14F, 1e-40F, 0, 1e14F, 0, 1e-40F}, "VEC3");
  thin.add_mesh_node({{"attributes", {{"POSITION", 0}}}});
  const Scene scene = thin.load();
  EXPECT_EQ(scene.triangles.size(), 1U);
  EXPECT_TRUE(scene.positions[1].allFinite());
  GltfWriter point;
  point.add_accessor(std::vector<float>(9, 1e14F), "VEC3");
  point.add_mesh_node({{"attributes", {{"POSITION", 0}}}});
  EXPECT_THROW(point.load(), UserError);
}

}  // namespace
}  // namespace prt
