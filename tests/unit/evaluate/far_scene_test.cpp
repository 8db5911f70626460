// A scene far from the world's origin, by the programs themselves: the Cornell box baked where it
// is, moved through a node, and stored with far vertices.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "support/program.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kPrograms = std::string(PRT_BINARY_DIR) + "/bin/";
const fs::path kCornell = fs::path(PRT_SOURCE_DIR) / "configs/scenes/cornell.glb";

/// A .glb taken apart.
struct Glb {
  json text;
  std::string binary;

  explicit Glb(const fs::path& file) {
    const std::string bytes = test::read_text(file);
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, sizeof size);
    text = json::parse(bytes.substr(20, size));
    binary = bytes.substr(20 + size + 8);
  }
  void write(const fs::path& file) const {
    std::ofstream(file, std::ios::binary) << testing::GltfWriter::glb_of(text.dump(), binary);
  }
};

/// All of the scene below one more node.
void move_by_node(Glb& glb, const json& translation) {
  json& roots = glb.text["scenes"][0]["nodes"];
  glb.text["nodes"].push_back({{"children", roots}, {"translation", translation}});
  roots = json::array({glb.text["nodes"].size() - 1});
}

/// Every vertex of every mesh, and the nodes of camera and lights.
void move_by_vertices(Glb& glb, const std::array<float, 3>& by) {
  for (const json& mesh : glb.text["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      json& accessor = glb.text["accessors"][primitive["attributes"]["POSITION"].get<int>()];
      const json& view = glb.text["bufferViews"][accessor["bufferView"].get<int>()];
      char* at = glb.binary.data() + view.value("byteOffset", 0);
      for (int v = 0; v < 3 * accessor["count"].get<int>(); ++v, at += sizeof(float)) {
        float value = 0.0F;
        std::memcpy(&value, at, sizeof value);
        value += by[static_cast<std::size_t>(v % 3)];
        std::memcpy(at, &value, sizeof value);
      }
      accessor.erase("min");
      accessor.erase("max");
    }
  }
  for (json& node : glb.text["nodes"]) {
    if (!node.contains("translation")) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      node["translation"][c] = node["translation"][c].get<double>() + by[c];
    }
  }
}

struct Outcome {
  int code;
  std::string text;
};

/// Small bakes of the box: "home" where it is; "even" and "odd" moved through a node; "stored" with
/// its vertices moved.
class FarScene : public ::testing::Test {
 protected:
  inline static const json kEven = {1e5, -0x1p16, 0x1p20};  // multiples of the box's step, 32 m
  inline static const json kOdd = {123456.7, -98765.4, 1e5};
  static constexpr std::array<float, 3> kFar = {1e5F, 0.0F, -1e5F};

  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    fs::copy_file(kCornell, file("home.glb"));
    Glb even(kCornell), odd(kCornell), stored(kCornell);
    move_by_node(even, kEven);
    move_by_node(odd, kOdd);
    move_by_vertices(stored, kFar);
    even.write(file("even.glb"));
    odd.write(file("odd.glb"));
    stored.write(file("stored.glb"));
    std::ofstream(file("box.yaml")) << "scene: home.glb\nsamples: {count: 600, cluster_size: 100}\n"
                                       "rays: {directions: 144}\n"
                                       "lb: {visibility_rank: 12, light_rank: 6, "
                                       "example_lights: 100}\n"
                                       "evaluate: {lights: 24, points: 300, spp: 32}\n";
    for (const char* name : {"home", "even", "odd", "stored"}) bake(name, name);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string file(const std::string& name) { return (folder_->path / name).string(); }
  static std::string package(const std::string& bake) {
    return file(bake + "/" + bake + ".prt.glb");
  }
  static json report(const std::string& bake) {
    return json::parse(test::read_text(file(bake + "/report.json")));
  }
  static Outcome run(const std::string& program, std::vector<std::string> words) {
    words.insert(words.begin(), kPrograms + program);
    test::Program child(words, file("log.txt"));
    const int code = child.wait();
    return {code, child.output()};
  }
  /// The scene's bake in a folder of that name; its log is NAME.log.
  static void bake(const std::string& scene, const std::string& name,
                   const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {
        file("box.yaml"), "--threads", "2", "--set", "scene=" + file(scene) + ".glb",
        "--out",          file(name)};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run("prt_bake", words);
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    std::ofstream(file(name + ".log")) << outcome.text;
  }
  /// Size and hash of every artifact, by stage and KEY.
  static std::map<std::string, std::string> artifacts(const std::string& bake) {
    auto results = test::bake_results(file(bake));
    EXPECT_EQ(results.erase(bake + ".prt.glb"), 1U);
    EXPECT_GT(results.size(), 20U);
    return results;
  }
  static std::vector<std::vector<std::string>> table(const std::string& name) {
    std::vector<std::vector<std::string>> rows;
    std::ifstream in(file(name));
    for (std::string line; std::getline(in, line);) {
      rows.emplace_back();
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  }
  /// `x,y,z` of a place of the box, moved.
  static std::string place(const std::array<double, 3>& p, const json& move) {
    std::string text;
    for (std::size_t c = 0; c < 3; ++c) {
      text += (c > 0 ? "," : "") + json(p[c] + move[c].get<double>()).dump();
    }
    return text;
  }

  inline static test::TemporaryFolder* folder_ = nullptr;
};

const json kHome = {0.0, 0.0, 0.0};
/// So fine that at 1e5 m a float would not hold it, and both float and double do at home.
constexpr double kFine = 0x1p-14;
constexpr std::array<double, 3> kLamp = {2.75 + kFine, 4.5, -2.5 - kFine};
const std::vector<std::array<double, 3>> kPoints = {
    {2.75 + kFine, 0.0, -2.0}, {1.0, 0.0, -1.0}, {5.0, 0.0, -0.75}};

TEST_F(FarScene, MovedThroughANodeAllArtifactsAreTheSame) {
  EXPECT_EQ(artifacts("even"), artifacts("home"));
  EXPECT_EQ(report("even")["scene"]["origin"], kEven);
  EXPECT_EQ(report("home")["scene"]["origin"], kHome);
  EXPECT_TRUE(report("home")["scene"]["repair_notes"].empty());
  EXPECT_NE(test::read_text(file("even.log")).find("positions are kept relative to"),
            std::string::npos);
}

TEST_F(FarScene, TheStartOfSamplingIsAPlaceInTheWorld) {
  const auto start = [](const json& move) {
    return "samples.start=[" + place({2.75 + kFine, 2.5, -2.5}, move) + "]";
  };
  bake("home", "home_start", {"--set", start(kHome), "--set", "evaluate.lights=0"});
  bake("even", "even_start", {"--set", start(kEven), "--set", "evaluate.lights=0"});
  EXPECT_EQ(artifacts("even_start"), artifacts("home_start"));
  EXPECT_NE(artifacts("home_start"), artifacts("home"));
}

TEST_F(FarScene, PointsAndLightsAreInTheWorld) {
  for (const std::string form : {"played", "traced"}) {
    std::map<std::string, std::vector<std::vector<std::string>>> tables;
    for (const auto& [bake, move] : {std::pair{"home", kHome}, {"even", kEven}}) {
      std::string csv = "x,y,z,nx,ny,nz\n";
      for (const auto& p : kPoints) csv += place(p, move) + ",0,1,0\n";
      std::ofstream(file("points.csv")) << csv;
      std::vector<std::string> words = {"--points", file("points.csv"),
                                        "--light",  "point:" + place(kLamp, move) + ":9,8,7",
                                        "-o",       file("out.csv")};
      if (form == "played") {
        words.insert(words.begin(), package(bake));
      } else {
        words.insert(words.begin(),
                     {"--reference", file(std::string(bake) + ".glb"), "--spp", "8"});
      }
      const Outcome outcome = run("prt_eval", words);
      ASSERT_EQ(outcome.code, 0) << outcome.text;
      tables[bake] = table("out.csv");
      // Where they came in, to the last digit.
      for (std::size_t i = 0; i < kPoints.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_EQ(std::stod(tables[bake].at(i + 1).at(c)), kPoints[i][c] + move[c].get<double>());
        }
      }
    }
    ASSERT_EQ(tables["home"].size(), kPoints.size() + 1);
    EXPECT_GT(std::stod(tables["home"][1].at(6)), 0.0) << form << ": it is lit";
    for (std::size_t i = 1; i < tables["home"].size(); ++i) {
      for (std::size_t c = 3; c < 12; ++c) {
        EXPECT_EQ(tables["even"][i].at(c), tables["home"][i].at(c)) << form;
      }
    }
  }
}

TEST_F(FarScene, PicturesAreTheSame) {
  std::string pictures[2];
  std::string* picture = pictures;
  for (const auto& [bake, move] : {std::pair{"home", kHome}, {"even", kEven}}) {
    const Outcome outcome =
        run("prt_play",
            {package(bake), "--light", "point:" + place(kLamp, move) + ":9,8,7", "--camera",
             place({2.75 + kFine, 2.75, 4.0}, move) + "," + place({2.75, 2.5, -2.0}, move) + ",60",
             "--size", "64x48", "--out", file("picture.png")});
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    *picture++ = test::read_text(file("picture.png"));
  }
  EXPECT_FALSE(pictures[0].empty());
  EXPECT_EQ(pictures[1], pictures[0]);
}

TEST_F(FarScene, ErrorsAreTheSameAndNameLightsInTheWorld) {
  json errors[2];
  json* error = errors;
  for (const char* bake : {"home", "even"}) {
    const Outcome outcome = run(
        "prt_eval", {package(bake), "--lights", "2", "--spp", "4", "--json", file("error.json")});
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    *error++ = json::parse(test::read_text(file("error.json")));
  }
  EXPECT_EQ(errors[1]["indirect"]["rel_rmse"], errors[0]["indirect"]["rel_rmse"]);
  EXPECT_EQ(errors[1]["visibility_error"], errors[0]["visibility_error"]);
  const auto expect_moved = [](const json& far, const json& near) {
    const json& p = far["direct"]["worst_light"]["position"];
    const json& q = near["direct"]["worst_light"]["position"];
    ASSERT_EQ(q.size(), 3U);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(p[c].get<double>(), q[c].get<double>() + kEven[c].get<double>());
    }
  };
  expect_moved(errors[1], errors[0]);
  expect_moved(report("even")["error"], report("home")["error"]);
}

/// Errors of a bake whose samples are others within two standard errors.
void expect_alike(const json& far, const json& home) {
  for (const char* part : {"direct", "indirect"}) {
    const json& a = far["error"][part];
    const json& b = home["error"][part];
    double variance = 0.0;
    for (const json* e : {&a, &b}) {
      for (const char* share : {"standard_error", "light_error"}) {
        variance += std::pow((*e)[share].get<double>(), 2);
      }
    }
    EXPECT_NEAR(a["rel_rmse"].get<double>(), b["rel_rmse"].get<double>(), 2.0 * std::sqrt(variance))
        << part;
    EXPECT_GT(b["rel_rmse"].get<double>(), 2.0 * std::sqrt(variance)) << "or nothing is tested";
  }
}

TEST_F(FarScene, MovedByAnyLengthThroughANodeItIsAsGood) {
  expect_alike(report("odd"), report("home"));
  EXPECT_LT(report("odd")["scene"]["vertex_rounding"], 1e-6);
}

TEST_F(FarScene, StoredFarOutItBakesAndSaysWhatIsLost) {
  expect_alike(report("stored"), report("home"));
  // Half of the 2^-7 m that float numbers are apart at 1e5.
  EXPECT_EQ(report("stored")["scene"]["vertex_rounding"], 0x1p-8);
  for (const std::string& text :
       {test::read_text(file("stored.log")), report("stored")["scene"]["repair_notes"].dump(),
        test::read_text(file("stored/report.html"))}) {
    EXPECT_NE(text.find("from the origin of their own mesh: positions are good to 3.9 mm"),
              std::string::npos)
        << text;
  }
}

TEST_F(FarScene, HostileOriginsAreToldInOneLine) {
  for (const char* origin : {"[1e300,0,0]", "\"there\"", "[0,0,0]", "[100000,-65536,1048577]"}) {
    Glb glb(package("even"));
    glb.text["extensions"]["PRT_light_transfer"]["origin"] = json::parse(origin);
    glb.write(file("hostile.prt.glb"));
    for (const char* program : {"prt_play", "prt_eval"}) {
      const Outcome outcome = run(program, {file("hostile.prt.glb")});
      EXPECT_EQ(outcome.code, 2) << origin << ": " << outcome.text;
      EXPECT_NE(outcome.text.find("hostile.prt.glb"), std::string::npos) << outcome.text;
      const std::string own = outcome.text.substr(outcome.text.find(std::string(program) + ": "));
      EXPECT_EQ(std::ranges::count(own, '\n'), 1) << outcome.text;
    }
  }
}

TEST_F(FarScene, ItsPackageIsValidGltf) {
  if (!fs::exists(fs::path(PRT_SOURCE_DIR) / "build/gltf-validator/node_modules/gltf-validator")) {
    GTEST_SKIP() << "no gltf-validator: scripts/validate_package installs it";
  }
  const fs::path script = fs::path(PRT_SOURCE_DIR) / "scripts/validate_package";
  test::Program child({script.string(), package("even"), package("odd")}, file("log.txt"));
  EXPECT_EQ(child.wait(), 0) << child.output();
}

}  // namespace
}  // namespace prt
