// prt_eval as scripts call it: its three forms on a bake of the closed box, and rubbish.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "support/program.h"

namespace prt {
namespace {

namespace fs = std::filesystem;

const std::string kPrograms = std::string(PRT_BINARY_DIR) + "/bin/";
const std::string kScene = std::string(PRT_SOURCE_DIR) + "/configs/scenes/closed_box.glb";
// Half a metre above the middle of a box of 2 m.
const std::string kLight = "point:0,0.5,0:1,1,1";
constexpr double kHeight = 1.5;  // of the light over the floor, m
constexpr double kWritten = 1e-6;
// 300 samples, low ranks and 4 paths are made for speed.
constexpr double kCoarse = 0.5;

struct Outcome {
  int code;
  std::string text;
};

/// A folder with a small bake of the closed box, made once.
class EvalProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    write("box.yaml", "scene: " + kScene +
                          "\noutput: box\nsamples: {count: 300, cluster_size: 100}\n"
                          "rays: {directions: 64}\n"
                          "lb: {visibility_rank: 8, light_rank: 4, example_lights: 30}\n"
                          "evaluate: {lights: 1, points: 50, spp: 4}\n");
    const Outcome bake = run("prt_bake", {file("box.yaml"), "--threads", "1", "-q"});
    ASSERT_EQ(bake.code, 0) << bake.text;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string file(const std::string& name) { return (folder_->path / name).string(); }
  static std::string package() { return file("box/box.prt.glb"); }
  static void write(const std::string& name, const std::string& text) {
    std::ofstream(file(name)) << text;
  }
  static Outcome run(const std::string& program, std::vector<std::string> words) {
    words.insert(words.begin(), kPrograms + program);
    test::Program child(words, file("log.txt"));
    const int code = child.wait();
    return {code, child.output()};
  }
  static std::vector<std::string> lines(const std::string& name) {
    std::vector<std::string> all;
    std::ifstream in(file(name));
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  static std::vector<double> numbers(const std::string& line) {
    std::vector<double> all;
    std::istringstream in(line);
    for (std::string word; std::getline(in, word, ',');) all.push_back(std::stod(word));
    return all;
  }

 private:
  inline static test::TemporaryFolder* folder_ = nullptr;
};

const std::string kHeader =
    "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b";

TEST_F(EvalProgram, PlaysAndTracesTheSamePoints) {
  write("floor.csv", "x,y,z,nx,ny,nz\n0,-1,0,0,1,0\n");
  const Outcome played = run("prt_eval", {package(), "--points", file("floor.csv"), "--light",
                                          kLight, "-o", file("played.csv")});
  ASSERT_EQ(played.code, 0) << played.text;
  const Outcome traced =
      run("prt_eval", {"--reference", kScene, "--points", file("floor.csv"), "--light", kLight,
                       "--spp", "64", "-o", file("traced.csv")});
  ASSERT_EQ(traced.code, 0) << traced.text;
  for (const char* name : {"played.csv", "traced.csv"}) {
    const auto out = lines(name);
    ASSERT_EQ(out.size(), 2U) << name;
    EXPECT_EQ(out[0], kHeader) << name;
    const auto v = numbers(out[1]);
    ASSERT_EQ(v.size(), 12U) << name;
    EXPECT_EQ(std::vector<double>(v.begin(), v.begin() + 6),
              (std::vector<double>{0, -1, 0, 0, 1, 0}));
    // The light is straight above: I / h². Played, it is a mean over some samples around.
    const bool exact = std::string(name) == "traced.csv";
    EXPECT_NEAR(v[6] * kHeight * kHeight, 1.0, exact ? kWritten : kCoarse) << name;
    EXPECT_GT(v[9], 0.0) << name;
  }
  const double truth = numbers(lines("traced.csv")[1])[9];
  EXPECT_NEAR(numbers(lines("played.csv")[1])[9] / truth, 1.0, kCoarse);
}

TEST_F(EvalProgram, SaysNanWhereNoSplatReaches) {
  write("far.csv", "x,y,z,nx,ny,nz\n0,-1,0,0,1,0\n50,0,0,1,0,0\n");
  const Outcome outcome = run("prt_eval", {package(), "--points", file("far.csv"), "--light",
                                           kLight, "-o", file("far_out.csv")});
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("1 of 2 points"), std::string::npos) << outcome.text;
  EXPECT_EQ(lines("far_out.csv").at(2), "50,0,0,1,0,0,nan,nan,nan,nan,nan,nan");
}

TEST_F(EvalProgram, RefusesRubbishInOneLine) {
  struct Rubbish {
    std::string text, said;
  };
  for (const Rubbish& r : {Rubbish{"", "rubbish.csv"}, Rubbish{"x,y,z\n1,2,3\n", "rubbish.csv"},
                           Rubbish{"x,y,z,nx,ny,nz\n0,-1,zero,0,1,0\n", "rubbish.csv:2"},
                           Rubbish{"x,y,z,nx,ny,nz\n0,-1,0,0,1,0\n0,-1,0,0,1\n", "rubbish.csv:3"},
                           Rubbish{"x,y,z,nx,ny,nz\n0,-1,inf,0,1,0\n", "rubbish.csv:2"},
                           Rubbish{"x,y,z,nx,ny,nz\n0,-1,0,0,0,0\n", "rubbish.csv:2"},
                           Rubbish{std::string("\x89PNG\r\n\0\0", 8), "rubbish.csv"}}) {
    write("rubbish.csv", r.text);
    for (const auto& input :
         {std::vector<std::string>{package()}, std::vector<std::string>{"--reference", kScene}}) {
      auto words = input;
      words.insert(words.end(),
                   {"--points", file("rubbish.csv"), "--light", kLight, "-o", file("never.csv")});
      const Outcome outcome = run("prt_eval", words);
      EXPECT_EQ(outcome.code, 2) << r.text;
      EXPECT_NE(outcome.text.find(r.said), std::string::npos) << outcome.text;
      const std::string own = outcome.text.substr(outcome.text.find("prt_eval: "));
      EXPECT_EQ(std::count(own.begin(), own.end(), '\n'), 1) << outcome.text;
      EXPECT_FALSE(fs::exists(file("never.csv")));
    }
  }
}

TEST_F(EvalProgram, WritesTheKeysThatScriptsRead) {
  const Outcome outcome =
      run("prt_eval", {package(), "--lights", "2", "--seed", "5", "--spp", "4", "--json",
                       file("error.json"), "--pictures", file("pictures")});
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(fs::exists(file("pictures/light-0000.png")));
  EXPECT_TRUE(fs::exists(file("pictures/light-0001.png")));
  const auto json = nlohmann::json::parse(test::read_text(file("error.json")));
  for (const char* part : {"direct", "indirect"}) {
    for (const std::string& place : {std::string("/"), std::string("/surface/")}) {
      for (const char* figure :
           {"rel_rmse", "rel_rmse_light/median", "rel_rmse_light/p95", "standard_error"}) {
        const nlohmann::json::json_pointer key("/" + (part + place) + figure);
        ASSERT_TRUE(json.contains(key)) << key.to_string();
        EXPECT_TRUE(json[key].is_number()) << key.to_string();
        EXPECT_GE(json[key].get<double>(), 0.0) << key.to_string();
      }
    }
  }
  for (const char* key : {"visibility_error", "visibility_error_soft", "visibility_error_weighted",
                          "package_bytes", "bake_seconds", "play_ms"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_TRUE(json[key].is_number()) << key;
  }
  ASSERT_FALSE(json["bake_stages"].empty());
  EXPECT_TRUE(json["bake_stages"][0]["stage"].is_string());
  EXPECT_GE(json["bake_stages"][0]["cpu_seconds"], json["bake_stages"][1]["cpu_seconds"]);
  EXPECT_LT(json["indirect"]["worst_light"]["light"], 2U);
  EXPECT_EQ(json["indirect"]["worst_light"]["position"].size(), 3U);
  EXPECT_LE(json["indirect"]["worst_cluster"]["error_share"].get<double>(), 1.0);
  EXPECT_EQ(json["lights"], 2);
  EXPECT_EQ(json["seed"], 5);
  EXPECT_EQ(json["package_bytes"], fs::file_size(package()));
}

TEST_F(EvalProgram, JudgesEnvironmentsWhereThePackageTakesThem) {
  write("open.yaml", "scene: " + std::string(PRT_SOURCE_DIR) +
                         "/configs/scenes/cornell.glb\noutput: open\nmethods: [sh]\n"
                         "samples: {count: 300, cluster_size: 100}\nrays: {directions: 64}\n"
                         "evaluate: {environments: 1, points: 50, spp: 4}\n");
  const Outcome bake = run("prt_bake", {file("open.yaml"), "--threads", "1", "-q"});
  ASSERT_EQ(bake.code, 0) << bake.text;
  const std::string open = file("open/open.prt.glb");
  const Outcome judged = run("prt_eval", {open, "--env", "sky:1,1,1", "--env", "lobes:1,1,1",
                                          "--spp", "4", "--json", file("sky.json")});
  ASSERT_EQ(judged.code, 0) << judged.text;
  const auto json = nlohmann::json::parse(test::read_text(file("sky.json")));
  for (const char* part : {"direct", "indirect", "total"}) {
    EXPECT_TRUE(json[part]["rel_rmse"].is_number()) << part;
    EXPECT_TRUE(json[part]["surface"]["rel_rmse"].is_number()) << part;
  }
  EXPECT_EQ(json["environments"], 2);
  EXPECT_EQ(json["order"], 5);
  EXPECT_TRUE(json["play_ms"].is_number());
  const auto report = nlohmann::json::parse(test::read_text(file("open/report.json")));
  EXPECT_EQ(report["error"]["environment"]["environments"], 1);
  // Points, played and path traced.
  write("point.csv", "x,y,z,nx,ny,nz\n4.5,0,-0.8,0,1,0\n");
  ASSERT_EQ(run("prt_eval", {open, "--points", file("point.csv"), "--env", "sky:1,2,4", "-o",
                             file("by_package.csv")})
                .code,
            0);
  ASSERT_EQ(
      run("prt_eval",
          {"--reference", std::string(PRT_SOURCE_DIR) + "/configs/scenes/cornell.glb", "--points",
           file("point.csv"), "--env", "sky:1,2,4", "--spp", "4096", "-o", file("by_paths.csv")})
          .code,
      0);
  const auto played = numbers(lines("by_package.csv")[1]);
  const auto traced = numbers(lines("by_paths.csv")[1]);
  EXPECT_NEAR(played[7] / played[6], 2.0, 1e-4);
  EXPECT_NEAR(played[6] / traced[6], 1.0, kCoarse);
  EXPECT_NEAR(played[9] / traced[9], 1.0, kCoarse);
  EXPECT_GT(traced[6], 0.0);
  // What does not go together ends in one line.
  for (const auto& words :
       {std::vector<std::string>{package(), "--env", "sky:1,1,1"},
        {open},
        {open, "--env", "sky:1,1"},
        {open, "--env", "none.hdr"},
        {open, "--env", "sky:1,1,1", "--lights", "3"},
        {open, "--points", file("point.csv"), "--light", kLight, "-o", file("never.csv")}}) {
    const Outcome refused = run("prt_eval", words);
    EXPECT_EQ(refused.code, 2) << refused.text;
    const std::string own = refused.text.substr(refused.text.find("prt_eval: "));
    EXPECT_EQ(std::count(own.begin(), own.end(), '\n'), 1) << refused.text;
  }
}

TEST_F(EvalProgram, NumbersThatAreNoneAreRefusedByPrograms) {
  for (const auto& words : {std::vector<std::string>{"--rotate", "nan"},
                            {"--reflection", "nan"},
                            {"--exposure", "inf"},
                            {"--exposure", "nan"},
                            {"--bench", "nan"}}) {
    std::vector<std::string> play = {package(), "--out", file("never.png")};
    play.insert(play.end(), words.begin(), words.end());
    const Outcome refused = run("prt_play", play);
    EXPECT_EQ(refused.code, 2) << words[0] << refused.text;
    EXPECT_NE(refused.text.find("not a finite number"), std::string::npos) << refused.text;
    EXPECT_FALSE(fs::exists(file("never.png")));
  }
  EXPECT_EQ(run("prt_eval", {package(), "--clearance", "nan"}).code, 2);
}

// Away from its report the package says nothing about its bake.
TEST_F(EvalProgram, KnowsNoBakeTimeWithoutTheReport) {
  fs::create_directory(file("moved"));
  fs::copy_file(package(), file("moved/box.prt.glb"));
  const Outcome outcome = run("prt_eval", {file("moved/box.prt.glb"), "--lights", "1", "--spp", "2",
                                           "--json", file("moved.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(
      nlohmann::json::parse(test::read_text(file("moved.json"))).at("bake_seconds").is_null());
}

}  // namespace
}  // namespace prt
