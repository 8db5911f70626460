// The bake service under real mpirun: whatever the number of ranks and threads, the bytes are the
// same, and what is wrong is said once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/manifest.h"
#include "toy_runs.h"

namespace prt {
namespace {

using test::count;
using test::kSlowTask;
using test::kTasks;
using test::log_of;
using test::Program;
using test::run;
using test::ToyFolder;
using test::ToyRun;

TEST(Ranks, AnyNumberOfRanksAndThreadsGivesTheSameBytes) {
  const ToyFolder alone;
  ASSERT_EQ(run(alone, {}), 0) << log_of(alone);
  const auto expected = alone.results();
  ASSERT_EQ(expected.size(), kTasks + 1);
  for (const ToyRun& r : {ToyRun{0, 2}, ToyRun{1, 1}, ToyRun{2, 1}, ToyRun{2, 2}, ToyRun{4, 1}}) {
    const ToyFolder folder;
    ASSERT_EQ(run(folder, r), 0) << log_of(folder);
    EXPECT_EQ(folder.results(), expected) << r.ranks << " ranks, " << r.threads << " threads";
  }
}

TEST(Ranks, OtherSeedsGiveOtherBytes) {
  const ToyFolder one, two;
  ASSERT_EQ(run(one, {}), 0);
  ASSERT_EQ(run(two, {0, 1, {"--set", "seed=2"}}), 0);
  EXPECT_NE(one.results(), two.results());
}

TEST(Ranks, EveryRankWorks) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {4, 1, {}, {{"PRT_TOY_SPIN_US", "5000"}}}), 0);
  const std::string manifest = test::read_text(folder.bake() / "manifest.log");
  for (const char* rank : {"\"rank\":0", "\"rank\":1", "\"rank\":2", "\"rank\":3"}) {
    EXPECT_THAT(manifest, testing::HasSubstr(rank));
  }
}

TEST(Ranks, AFinishedBakeIsVerifiedAndLeftAlone) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {}), 0);
  const auto before = folder.results();
  const std::string manifest = test::read_text(folder.bake() / "manifest.log");
  ASSERT_EQ(run(folder, {2, 1}), 0);
  EXPECT_THAT(log_of(folder), testing::HasSubstr("already done"));
  EXPECT_EQ(folder.results(), before);
  EXPECT_EQ(test::read_text(folder.bake() / "manifest.log"), manifest);
}

TEST(Ranks, DamagedAndForeignArtifactsAreMadeAgain) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {}), 0);
  const auto before = folder.results();
  std::vector<std::filesystem::path> files;
  for (const auto& [name, bytes] : before) {
    if (name.starts_with("artifacts/")) files.push_back(folder.bake() / name);
  }
  std::filesystem::resize_file(files[0], 100);
  std::filesystem::remove(files[1]);
  std::filesystem::copy_file(files[3], files[2], std::filesystem::copy_options::overwrite_existing);
  std::ofstream(files.back()) << "rubbish";
  ASSERT_EQ(run(folder, {2, 1}), 0) << log_of(folder);
  EXPECT_EQ(folder.results(), before);
  EXPECT_THAT(log_of(folder), testing::HasSubstr("4 tasks made"));
}

TEST(Ranks, AManifestThatKnowsAnotherResultStopsTheBake) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {}), 0);
  PosixFileSystem disk;
  const auto path = folder.bake() / kManifestName;
  ManifestContents manifest = read_manifest(disk, path);
  manifest.entries.at(0).content = hash_text("another result");
  create_manifest(disk, path, manifest.identity, manifest.entries);
  EXPECT_EQ(run(folder, {2, 1}), 1);
  EXPECT_THAT(log_of(folder), testing::HasSubstr("determinism bug"));
  EXPECT_EQ(run(folder, {2, 1, {"--fresh"}}), 0);
}

TEST(Ranks, AChangedOptionKeepsWhatItDoesNotTouch) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {}), 0);
  ASSERT_EQ(run(folder, {0, 1, {"--set", "toy.leaves=42"}}), 0);
  // Two leaves, one pair, and the total.
  EXPECT_THAT(log_of(folder), testing::HasSubstr("4 tasks made, 60 found"));
}

TEST(Ranks, NeededKeepsOnlyWhatIsStillRead) {
  const ToyFolder folder("toy: {leaves: 40}\nstore: {keep: needed}");
  ASSERT_EQ(run(folder, {}), 0) << log_of(folder);
  // The total, which the package is made of, and the leaf that planning looked at.
  EXPECT_EQ(folder.count_artifacts(), 2U);
  const auto before = folder.results();
  ASSERT_EQ(run(folder, {2, 1}), 0);
  EXPECT_THAT(log_of(folder), testing::HasSubstr("already done"));
  EXPECT_EQ(folder.results(), before);
  std::filesystem::remove_all(folder.bake() / "artifacts" / "total");
  ASSERT_EQ(run(folder, {2, 1}), 0) << log_of(folder);
  EXPECT_EQ(folder.results(), before);
}

TEST(Ranks, AUserErrorIsOneLineAndExitCode2) {
  for (const int ranks : {0, 2}) {
    const ToyFolder folder;
    EXPECT_EQ(run(folder, {ranks, 1, {"--set", "toy.leafs=3"}}), 2);
    EXPECT_EQ(count(log_of(folder), "prt_bake: "), 1U) << log_of(folder);
    EXPECT_THAT(log_of(folder), testing::HasSubstr("toy.leaves"));
    std::filesystem::remove(folder.path / "toy.scene");
    EXPECT_EQ(run(folder, {ranks, 1}), 2);
    EXPECT_EQ(count(log_of(folder), "prt_bake: "), 1U) << log_of(folder);
  }
}

TEST(Ranks, TwoBakesInOneFolderAreRefused) {
  const ToyFolder folder;
  const auto first = folder.start({0, 1, {}, {{"PRT_TOY_SPIN_US", kSlowTask}}}, PRT_MPIRUN);
  while (folder.count_artifacts() == 0 && !first->finished()) std::this_thread::yield();
  const std::string log = (folder.path / "second.txt").string();
  Program second(
      {std::string(PRT_BINARY_DIR) + "/bin/toy_bake", (folder.path / "toy.yaml").string()}, log);
  EXPECT_EQ(second.wait(), 2);
  EXPECT_THAT(second.output(), testing::HasSubstr("another bake is writing here"));
}

TEST(Ranks, ABakeIsWatchedFromAnotherProcessUntilItIsFinished) {
  const ToyFolder folder;
  const auto bake = folder.start({0, 2, {}, {{"PRT_TOY_SPIN_US", "50000"}}}, PRT_MPIRUN);
  while (folder.count_artifacts() == 0 && !bake->finished()) std::this_thread::yield();
  Program watcher(
      {std::string(PRT_BINARY_DIR) + "/bin/prt_inspect", "--watch", folder.bake().string()},
      folder.path / "watch.txt");
  EXPECT_EQ(bake->wait(), 0);
  EXPECT_EQ(watcher.wait(), 0) << watcher.output();
  EXPECT_GE(count(watcher.output(), "\n"), 2U) << watcher.output();
  EXPECT_THAT(watcher.output(), testing::HasSubstr("61 of 61 tasks"));
}

TEST(Ranks, AnotherScenesFolderIsRefusedUnlessFresh) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {}), 0);
  std::filesystem::rename(folder.path / "toy.scene", folder.path / "other.scene");
  const std::string scene = "scene=" + (folder.path / "other.scene").string();
  EXPECT_EQ(run(folder, {2, 1, {"--set", scene}}), 2);
  EXPECT_THAT(log_of(folder), testing::HasSubstr("holds another bake"));
  EXPECT_EQ(run(folder, {2, 1, {"--set", scene, "--fresh"}}), 0);
}

TEST(Ranks, PlanMakesNothing) {
  const ToyFolder folder;
  ASSERT_EQ(run(folder, {2, 1, {"--plan"}}), 0);
  EXPECT_FALSE(std::filesystem::exists(folder.bake()));
  EXPECT_THAT(log_of(folder), testing::HasSubstr("later stages are planned"));
  ASSERT_EQ(run(folder, {}), 0);
  ASSERT_EQ(run(folder, {0, 1, {"--plan"}}), 0);
  EXPECT_THAT(log_of(folder), testing::HasSubstr("left out: the odd leaf: it has no partner"));
}

TEST(Ranks, TraceHasOneEventPerTask) {
  const ToyFolder folder;
  const std::string trace = (folder.path / "trace.json").string();
  ASSERT_EQ(run(folder, {2, 1, {"--trace", trace}}), 0);
  EXPECT_EQ(count(test::read_text(trace), "\"ph\":\"X\""), kTasks);
}

}  // namespace
}  // namespace prt
