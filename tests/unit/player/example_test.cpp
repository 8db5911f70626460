// The example of examples/ does what its text says: run as a user would, judged by closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "bases/spherical_harmonics.h"
#include "package/write.h"
#include "support/program.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

struct ColouredMesh {
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::vector<std::array<int, 3>> colours;
  std::vector<Vec3f> positions;
};

ColouredMesh read_ply(const std::filesystem::path& file) {
  std::istringstream in(test::read_text(file));
  ColouredMesh mesh;
  for (std::string line; std::getline(in, line) && line != "end_header";) {
    std::istringstream words(line);
    std::string element;
    std::string what;
    words >> element >> what;
    if (element == "element") words >> (what == "vertex" ? mesh.vertices : mesh.faces);
  }
  for (std::size_t v = 0; v < mesh.vertices; ++v) {
    Vec3f p;
    std::array<int, 3> c{};
    in >> p.x() >> p.y() >> p.z() >> c[0] >> c[1] >> c[2];
    mesh.positions.push_back(p);
    mesh.colours.push_back(c);
  }
  return mesh;
}

/// What the example shows of irradiance e (W/m²).
int shown(float e) { return static_cast<int>(std::lround(255.0F * std::sqrt(e / (1.0F + e)))); }

/// A vertex stands at distance h = 2 m below the light: irradiance I/h². Samples 0.1 m apart take
/// their light within 0.1 m of it, where it is at most 0.4 % less: half a step of the display.
constexpr int kShownError = 1;

class Example : public testing::Test {
 protected:
  static int run(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                 const std::string& example = "vertex_colours") {
    std::vector<std::string> command{std::string(PRT_BINARY_DIR) + "/bin/" + example};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return test::Program(command, log).wait();
  }
  test::TemporaryFolder folder_;
};

TEST_F(Example, ColoursTheVerticesOfAMesh) {
  constexpr float kSide = 4.0F;
  Package room = test::synthetic_room(
      {.size = Vec3f::Constant(kSide), .samples_per_edge = 40, .directions = 0});
  // Direct light alone, a vertex in the middle of the floor, and the light above it.
  room.spaces = {
      {"e", Space::Kind::kSampleIrradiance, static_cast<std::uint32_t>(room.samples.size())}};
  room.operators.clear();
  room.program = {DirectLightStep{"e", DirectLightStep::Shadow::kNone}, ReconstructStep{"e"}};
  const auto middle = static_cast<std::uint32_t>(room.scene.positions.size());
  test::add_quad(room.scene, {2, 0, 2}, {0, 0, 1}, {1, 0, 0}, 0, 6);
  SceneLight light;
  light.position = {2, 2, 2};
  light.intensity = {8, 4, 2};
  room.scene.lights = {light};
  const std::string file = (folder_.path / "room.prt.glb").string();
  write_package(room, file);

  ASSERT_EQ(run({file, (folder_.path / "out").string(), "11"}, folder_.path / "log"), 0)
      << test::read_text(folder_.path / "log");
  const ColouredMesh first = read_ply(folder_.path / "out0.ply");
  const ColouredMesh second = read_ply(folder_.path / "out10.ply");
  EXPECT_EQ(first.vertices, room.scene.positions.size());
  EXPECT_EQ(first.faces, room.scene.triangles.size());
  std::size_t found = 0;
  for (std::size_t v = 0; v < first.vertices; ++v) {
    if (!first.positions[v].isApprox(room.scene.positions[middle])) continue;
    ++found;
    for (std::size_t c = 0; c < 3; ++c) {
      const float irradiance = light.intensity[static_cast<Eigen::Index>(c)] / 4.0F;
      EXPECT_NEAR(first.colours[v][c], shown(irradiance), kShownError) << c;
    }
    EXPECT_LT(second.colours[v][0], first.colours[v][0]) << "the light has gone away";
  }
  EXPECT_EQ(found, 1U);
}

TEST_F(Example, WritesTheTransferOfVertices) {
  constexpr int kOrder = 3;
  constexpr double kSixDigits = 1e-4;  // of a stream, and unit vectors of 16 bits
  Package room = test::synthetic_room({.samples_per_edge = 8, .directions = 0});
  test::add_environment(room, kOrder);
  room.program = {EnvironmentLightStep{"sky", "sky light", "sky"}, ReconstructStep{"sky"}};
  const std::string file = (folder_.path / "room.prt.glb").string();
  const auto log = folder_.path / "log", csv = folder_.path / "out.csv";
  write_package(room, file);
  ASSERT_EQ(run({file, csv.string()}, log, "vertex_transfer"), 0) << test::read_text(log);
  std::istringstream in(test::read_text(csv));
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line); ++lines) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream numbers(line);
    std::vector<double> v;
    for (double number = 0.0; numbers >> number;) v.push_back(number);
    ASSERT_EQ(v.size(), 6U + 3U * kOrder * kOrder);
    const VectorD expected = lambert_sh(kOrder, Vec3d(v[3], v[4], v[5]));
    for (int k = 0; k < kOrder * kOrder; ++k) {
      for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(v[static_cast<std::size_t>(6 + channel * kOrder * kOrder + k)], expected[k],
                    kSixDigits);
      }
    }
  }
  EXPECT_EQ(lines, room.scene.positions.size());
  write_package(test::synthetic_room({.directions = 0}), file);
  EXPECT_EQ(run({file, csv.string()}, log, "vertex_transfer"), 2);
  EXPECT_NE(test::read_text(log).find("no environment layer"), std::string::npos);
}

TEST_F(Example, SaysInOneLineWhatIsWrong) {
  const auto log = folder_.path / "log";
  EXPECT_EQ(run({(folder_.path / "none.prt.glb").string(), "out", "1"}, log), 2);
  const std::string said = test::read_text(log);
  EXPECT_EQ(said.find("vertex_colours: "), 0U);
  EXPECT_EQ(said.find('\n'), said.size() - 1);
  const std::string file = (folder_.path / "room.prt.glb").string();
  write_package(test::synthetic_room({.directions = 0}), file);
  EXPECT_EQ(run({file, (folder_.path / "no/such/folder/out").string(), "1"}, log), 2);
  EXPECT_EQ(run({file, (folder_.path / "out").string(), "many"}, log), 2);
}

}  // namespace
}  // namespace prt
