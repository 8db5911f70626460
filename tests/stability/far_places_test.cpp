// Scenes far from the world's origin, as a file brings them.
#include <gtest/gtest.h>

#include "stability/cases.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

using test::expect_alike;
using test::expect_sound;
using test::furnished;
using test::quality;
using test::Quality;
using test::record;
using test::SmallBake;

/// The scene written to a file and loaded again, with its vertices and its node moved.
Scene through_file(const Scene& scene, const Vec3f& vertices, const Vec3d& node) {
  testing::GltfWriter writer;
  for (std::uint32_t m = 0; m < scene.materials.size(); ++m) {
    std::vector<float> positions;
    for (const Triangle& triangle : scene.triangles) {
      if (triangle.material != m) continue;
      for (const std::uint32_t v : triangle.vertex) {
        const Vec3f p = scene.positions[v] + vertices;
        positions.insert(positions.end(), p.data(), p.data() + 3);
      }
    }
    const Vec3f& albedo = scene.materials[m].base_color;
    const auto material = writer.append(
        "materials", {{"pbrMetallicRoughness",
                       {{"baseColorFactor", {albedo.x(), albedo.y(), albedo.z(), 1.0}}}}});
    writer.add_mesh_node({{"attributes", {{"POSITION", writer.add_accessor(positions, "VEC3")}}},
                          {"material", material}},
                         {{"translation", {node.x(), node.y(), node.z()}}});
  }
  return writer.load();
}

TEST(FarPlaces, ThroughANodeNoBitChanges) {
  const Scene home = through_file(furnished(), Vec3f::Zero(), Vec3d::Zero());
  const SmallBake one(home);
  for (const Vec3d& move : {Vec3d(1e5, 2e4, -1e5), Vec3d(1e9, 0, 0)}) {
    const Scene far = through_file(furnished(), Vec3f::Zero(), move);
    EXPECT_EQ(far.origin, move);
    const SmallBake other(far);
    ASSERT_EQ(one.samples().size(), other.samples().size());
    std::size_t moved = 0;
    for (std::size_t s = 0; s < one.samples().size(); ++s) {
      moved += (one.samples().positions[s] != other.samples().positions[s]) ? 1 : 0;
    }
    EXPECT_EQ(moved, 0U);
    const Vec3f place(0.2F, 0.5F, 0.3F);
    const SampleIrradiance a = one.light(place);
    const SampleIrradiance b = other.light(relative_to(far.origin, move + place.cast<double>()));
    expect_sound(b, "far");
    EXPECT_LT((a.direct - b.direct).cwiseAbs().maxCoeff(), 1e-5F * a.direct.maxCoeff());
    EXPECT_LT((a.indirect - b.indirect).cwiseAbs().maxCoeff(), 1e-5F * a.indirect.maxCoeff());
    record(fmt::format("scene of 5 m moved by {:.0e} m through a node", move.x()),
           "same samples bit for bit, same light to 1e-5", fmt::format("{} samples moved", moved));
  }
}

TEST(FarPlaces, InItsVerticesTheFilesOwnRoundingIsLeft) {
  const Quality one = quality(furnished(), 1.0F, Vec3f::Zero());
  for (const float metres : {1e4F, 1e5F}) {
    const Vec3f move(metres, 0.2F * metres, -metres);
    const Scene far = through_file(furnished(), move, Vec3d::Zero());
    ASSERT_FALSE(far.repairs.notes.empty());
    EXPECT_NE(far.repairs.notes.back().find("good to"), std::string::npos);
    expect_alike(
        fmt::format("scene of 5 m stored {:.0e} m from its mesh's origin, vertices good to "
                    "{:.2g} mm, which is said",
                    metres, 1e3 * far.vertex_rounding),
        one, quality(far, 1.0F, relative_to(far.origin, move.cast<double>())));
  }
}

}  // namespace
}  // namespace prt
