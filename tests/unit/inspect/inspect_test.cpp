#include "apps/inspect/inspect.h"

#include "apps/inspect/clusters_image.h"
#include "apps/inspect/depth_image.h"
#include "apps/inspect/verify.h"
#include "bases/depth_basis.h"
#include "operators/quantised.h"
#include "store/index.h"
#include "store/quantised_io.h"
#include "store/samples_io.h"
#include "store_fixtures.h"

namespace prt {
namespace {

namespace fs = std::filesystem;

constexpr int kDirections = 16;
constexpr int kPerSide = 20;

/// A floor of two clusters that faces up.
SampleSet floor_samples() {
  SampleSet samples;
  for (int x = 0; x < kPerSide; ++x) {
    for (int z = 0; z < kPerSide; ++z) {
      samples.positions.emplace_back(static_cast<float>(x) * 0.1F, 0.0F,
                                     static_cast<float>(z) * 0.1F);
      samples.normals.push_back(Vec3f::UnitY());
      samples.tangents.push_back(Vec3f::UnitX());
      samples.areas.push_back(0.01F);
      samples.radii.push_back(0.1F);
      samples.triangles.push_back(0);
    }
  }
  const std::uint32_t count = kPerSide * kPerSide;
  samples.cluster_begin = {0, count / 2, count};
  return samples;
}

class InspectTest : public testing::Test {
 protected:
  void SetUp() override {
    bake_ = folder_.path() / "bake";
    auto folder = BakeFolder::open(disk_, bake_, "test.glb", false);
    Artifact samples;
    put_samples(samples, floor_samples());
    const std::vector<std::uint32_t> roots = {105, 300};
    samples.put("root", std::span<const std::uint32_t>(roots), {2}, "1", "roots");
    finish(folder, "samples", "samples", samples);
    const std::vector<std::uint16_t> distances(2 * kDirections, pack_depth(1.0F, 4.0F, false));
    Artifact rays;
    rays.put("distance", std::span<const std::uint16_t>(distances), {2, kDirections}, "1", "z");
    rays.attributes = {{"cluster", 1}, {"samples", 2}, {"bound", 4.0}};
    finish(folder, "rays/0001", "rays", rays);
    Artifact visibility;
    const auto put = [&](const char* name, const MatrixF& m) {
      put_quantised(visibility, name, quantise(m, 32).matrix, "1", name);
    };
    put("mean", MatrixF::Constant(1, kDirections, 0.5F));
    put("basis", MatrixF::Constant(1, kDirections, 0.25F));
    put("coefficients", (MatrixF(2, 1) << 0.0F, 1.0F).finished());
    visibility.attributes = {{"cluster", 1}, {"samples", 2}, {"rank", 1}, {"energy", 0.5}};
    visibility.attributes["error"] = 0.125;
    finish(folder, "visibility/0001", "visibility", visibility);
    write_index(disk_, bake_, links_);
  }

  void finish(BakeFolder& folder, const std::string& task, const std::string& kind,
              const Artifact& artifact) {
    const Digest key = hash_text(task);
    const Digest content = folder.store().write(kind, key, artifact);
    folder.manifest().append({.task = task,
                              .kind = kind,
                              .key = key,
                              .content = content,
                              .seconds = 2.0,
                              .bytes = folder.store().bytes(kind, key)},
                             0.0);
    links_.push_back({task, kind, key});
  }
  fs::path file(const std::string& task, const std::string& kind) {
    return ArtifactStore(disk_, bake_).path(kind, hash_text(task));
  }
  ExitCode run(InspectCommand command, std::string* out = nullptr) {
    command.bake = bake_;
    std::string text;
    const ExitCode code = inspect(command, text);
    if (out != nullptr) *out = text;
    return code;
  }
  nlohmann::json run_json(bool verify, ExitCode expected) {
    InspectCommand command;
    command.json = true;
    command.verify = verify;
    std::string out;
    EXPECT_EQ(run(command, &out), expected);
    return nlohmann::json::parse(out);
  }

  TemporaryFolder folder_;
  fs::path bake_;
  PosixFileSystem disk_;
  std::vector<IndexEntry> links_;
};

TEST_F(InspectTest, TellsStagesAndClusters) {
  const auto json = run_json(false, ExitCode::kDone);
  EXPECT_EQ(json["bake"], "test.glb");
  EXPECT_EQ(json["complete"], false);
  ASSERT_EQ(json["stages"].size(), 3U);
  EXPECT_EQ(json["stages"][1]["stage"], "rays");
  EXPECT_EQ(json["stages"][1]["tasks"], 1);
  EXPECT_EQ(json["stages"][1]["bytes"], fs::file_size(file("rays/0001", "rays")));
  ASSERT_EQ(json["clusters"].size(), 1U);
  const auto& cluster = json["clusters"][0];
  EXPECT_EQ(cluster["cluster"], 1);
  EXPECT_EQ(cluster["samples"], 2);
  EXPECT_EQ(cluster["seconds"], 4.0);
  EXPECT_EQ(cluster["stages"]["visibility"]["rank"], 1);
  EXPECT_EQ(cluster["stages"]["visibility"]["error"], 0.125);
  EXPECT_FALSE(cluster["stages"].contains("rays"));
  std::string text;
  run({}, &text);
  EXPECT_NE(text.find("0.12500"), std::string::npos) << text;
  EXPECT_NE(text.find("Not complete"), std::string::npos) << text;
}

TEST_F(InspectTest, VerifiesASoundBake) {
  EXPECT_EQ(
      run_json(true, ExitCode::kDone)["verification"],
      (nlohmann::json{{"checked", 4}, {"not_kept", 0}, {"unsound", nlohmann::json::array()}}));
}

TEST_F(InspectTest, VerificationNamesEachUnsoundArtifactAndLeavesIt) {
  std::string bytes = read_text(file("rays/0001", "rays"));
  bytes[bytes.size() / 2] ^= 1;
  write_text(file("rays/0001", "rays"), bytes);
  fs::remove(file("samples", "samples"));  // the index says it is kept
  const auto unsound = run_json(true, ExitCode::kUnsound)["verification"]["unsound"];
  ASSERT_EQ(unsound.size(), 2U);
  EXPECT_EQ(unsound[0]["task"], "samples");
  EXPECT_EQ(unsound[1]["task"], "rays/0001");
  EXPECT_EQ(read_text(file("rays/0001", "rays")), bytes);
}

TEST_F(InspectTest, AnotherSoundArtifactIsNotTheOneThatTheManifestNames) {
  fs::remove(file("rays/0001", "rays"));
  Artifact other;
  put_counting<float>(other, "a", {3});
  ArtifactStore(disk_, bake_).write("rays", hash_text("rays/0001"), other);
  EXPECT_EQ(run_json(true, ExitCode::kUnsound)["verification"]["unsound"].size(), 1U);
}

TEST_F(InspectTest, WhatAFinishedBakeLetGoIsNotUnsound) {
  std::erase_if(links_, [](const IndexEntry& link) { return link.kind == "rays"; });
  write_index(disk_, bake_, links_);
  fs::remove(file("rays/0001", "rays"));
  const auto json = run_json(true, ExitCode::kDone);
  EXPECT_EQ(json["verification"]["not_kept"], 1);
  EXPECT_EQ(json["stages"][1]["not_kept"], 1);
  EXPECT_THROW(draw_depth(BakeReader(disk_, bake_), 1, 0), UserError);
}

TEST_F(InspectTest, ADamagedIndexIsUnsound) {
  std::string bytes = read_text(bake_ / kIndexName);
  bytes[200] ^= 1;
  write_text(bake_ / kIndexName, bytes);
  EXPECT_EQ(run_json(true, ExitCode::kUnsound)["verification"]["unsound"][0]["task"], "index");
}

TEST_F(InspectTest, DrawsBothPictures) {
  InspectCommand command;
  command.image = "clusters";
  command.output = folder_.path() / "clusters.png";
  EXPECT_EQ(run(command), ExitCode::kDone);
  command.image = "depth";
  command.cluster = 1;
  command.index = 1;
  command.output = folder_.path() / "depth.png";
  EXPECT_EQ(run(command), ExitCode::kDone);
  for (const char* name : {"clusters.png", "depth.png"}) {
    EXPECT_TRUE(read_text(folder_.path() / name).starts_with("\x89PNG")) << name;
  }
  command.output = folder_.path() / "none" / "depth.png";
  EXPECT_THROW(run(command), UserError);
}

TEST_F(InspectTest, RefusesSamplesThatAreNotThere) {
  const BakeReader bake(disk_, bake_);
  EXPECT_THROW(draw_depth(bake, 1, 2), UserError);
  EXPECT_THROW(draw_depth(bake, 0, 0), UserError);
  EXPECT_THROW(BakeReader(disk_, folder_.path()), UserError);
}

TEST_F(InspectTest, DepthPanelsShowCastAndReconstruction) {
  // Sample 0 comes back exactly (z = 1/2 everywhere), sample 1 a quarter too deep.
  const BakeReader bake(disk_, bake_);
  const auto pixel_of_panel = [&](int index, int panel) {
    constexpr int kLeft = 24, kStep = 344, kTop = 56, kInside = 100;
    return draw_depth(bake, 1, index).at(kLeft + panel * kStep + kInside, kTop + kInside);
  };
  EXPECT_EQ(pixel_of_panel(0, 0), pixel_of_panel(0, 1));
  EXPECT_NE(pixel_of_panel(1, 0), pixel_of_panel(1, 1));
  EXPECT_EQ(pixel_of_panel(1, 0), pixel_of_panel(0, 0));
  const auto red = pixel_of_panel(1, 2);
  EXPECT_GT(red[0], red[2]);
}

int count_unlike(const Drawing& picture, const std::array<std::uint8_t, 3>& background) {
  int count = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) count += picture.at(x, y) != background;
  }
  return count;
}

TEST(ClustersImage, ShowsFrontFacesOnlyInsideThePicture) {
  SampleSet samples = floor_samples();
  const Drawing seen = draw_clusters(samples, {}, 160, 120);
  const auto background = seen.at(0, 0);
  // A square seen from above at an angle fills a good part of the picture, and no corner.
  constexpr int kLeastPixels = 160 * 120 / 8;
  EXPECT_GT(count_unlike(seen, background), kLeastPixels);
  EXPECT_EQ(seen.at(159, 119), background);
  const std::uint32_t root = 210;
  EXPECT_NE(count_unlike(draw_clusters(samples, std::span(&root, 1), 160, 120), {255, 255, 255}),
            count_unlike(seen, {255, 255, 255}));
  for (Vec3f& n : samples.normals) n = -Vec3f::UnitY();
  EXPECT_EQ(count_unlike(draw_clusters(samples, {}, 160, 120), background), 0);
}

TEST(ValuesImage, UnlikeValuesHaveUnlikeColours) {
  const SampleSet samples = floor_samples();
  const auto middle_columns = [&](const std::vector<double>& values) {
    const Drawing d = draw_values(samples, make_cluster_values("x", values, false), 160, 120);
    std::set<std::array<std::uint8_t, 3>> colours;
    for (int x = 0; x < d.width(); ++x) colours.insert(d.at(x, d.height() / 2));
    return colours.size();
  };
  EXPECT_GT(middle_columns({1.0, 3.0}), middle_columns({2.0, 2.0}) + 2);
  EXPECT_THROW(draw_values(samples, make_cluster_values("x", {1.0}, false)), UnsoundData);
}

TEST(ClustersImage, RefusesWhatCannotBeDrawn) {
  SampleSet samples;
  samples.cluster_begin = {0};
  EXPECT_THROW(draw_clusters(samples, {}), UserError);
  samples = floor_samples();
  samples.positions[3].x() = kInfinity;
  EXPECT_THROW(draw_clusters(samples, {}), UserError);
}

TEST(InspectCommandLine, TakesTheContractAndRefusesTheRest) {
  const auto parse = [](std::vector<const char*> words) {
    words.insert(words.begin(), "prt_inspect");
    std::string message;
    return parse_inspect_command(static_cast<int>(words.size()), words.data(), message);
  };
  EXPECT_TRUE(parse({"dir", "--verify", "--json"})->verify);
  const auto depth =
      parse({"dir", "--image", "depth", "--cluster", "3", "--index", "5", "-o", "x.png"});
  EXPECT_EQ(depth->cluster, 3);
  EXPECT_EQ(depth->index, 5);
  EXPECT_FALSE(parse({"--help"}).has_value());
  const std::vector<std::vector<const char*>> bad = {
      {},
      {"dir", "--imagine"},
      {"dir", "--image", "walls", "-o", "x.png"},
      {"dir", "--image", "depth"},
      {"dir", "--image", "curves", "-o", "x.png"},
      {"dir", "--image", "depth", "--cluster", "-1", "-o", "x.png"},
      {"dir", "--image", "clusters", "--index", "1", "-o", "x.png"},
      {"dir", "--image", "clusters", "--verify", "-o", "x.png"},
      {"dir", "-o", "x.png"},
      {"dir", "--cluster", "1"}};
  for (const auto& words : bad) {
    EXPECT_THROW(parse(words), UserError) << (words.empty() ? "" : words.back());
  }
}

}  // namespace
}  // namespace prt
