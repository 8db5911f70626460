// The real method through the real service: not only its package, every artifact is the same
// whatever the ranks, threads and interruptions. (A value that only travels between processes, a
// memo shared by the tasks of one, or a race shows here and nowhere else.)
#include <gtest/gtest.h>

#include "support/program.h"

namespace prt {
namespace {

using test::BakeRun;
using Results = std::map<std::string, std::string>;

/// Small, but with several clusters, tasks of every kind and all three channels.
const std::vector<std::string> kTiny = {
    "samples.count=1200", "samples.cluster_size=150", "rays.directions=256", "lb.example_lights=80",
    "lb.photons=100000",  "evaluate.lights=2",        "evaluate.points=100", "evaluate.spp=4"};
constexpr std::size_t kLeastArtifacts = 50;

/// The parameter is one more setting.
class LbRanks : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::unique_ptr<test::Program> start(const std::string& name, BakeRun run) const {
    for (const std::string& option : kTiny) run.more.insert(run.more.end(), {"--set", option});
    run.more.insert(run.more.end(), {"--set", GetParam()});
    run.more.insert(run.more.end(), {"--out", bake(name).string()});
    const std::string source = PRT_SOURCE_DIR;
    return test::start_bake(
        {std::string(PRT_BINARY_DIR) + "/bin/prt_bake", source + "/configs/default.yaml", "--set",
         "scene=" + source + "/configs/scenes/cornell.glb"},
        run, PRT_MPIRUN, folder_.path / (name + ".txt"));
  }

  [[nodiscard]] test::fs::path bake(const std::string& name) const {
    return folder_.path / name / "room";
  }

  void finish(const std::string& name, const BakeRun& run) const {
    const auto program = start(name, run);
    ASSERT_EQ(program->wait(), 0) << program->output();
  }

  [[nodiscard]] std::size_t count_artifacts(const std::string& name) const {
    return test::count_artifacts(bake(name));
  }

  test::TemporaryFolder folder_;
};

void expect_same(const Results& expected, const Results& found, const std::string& what) {
  EXPECT_EQ(expected.size(), found.size()) << what;
  for (const auto& [name, bytes] : expected) {
    ASSERT_TRUE(found.contains(name)) << what << ": no " << name;
    EXPECT_TRUE(bytes == found.at(name)) << what << ": " << name << " differs";
  }
}

TEST_P(LbRanks, EveryArtifactIsTheSameForAnyRanksThreadsAndKills) {
  finish("alone", {0, 1});
  const Results expected = test::bake_results(bake("alone"));
  ASSERT_GE(expected.size(), kLeastArtifacts);
  finish("threads", {0, 2});
  expect_same(expected, test::bake_results(bake("threads")), "two threads");
  finish("ranks", {2, 1});
  expect_same(expected, test::bake_results(bake("ranks")), "two ranks");

  const std::size_t all = expected.size() - 1;  // but for the package
  std::size_t reached = 0;
  for (const std::size_t at : {all / 4, all * 3 / 5}) {
    const auto killed = start("killed", {2, 1});
    while (count_artifacts("killed") < at && !killed->finished()) std::this_thread::yield();
    ASSERT_FALSE(killed->finished()) << killed->output();
    killed->kill_all();
    reached = count_artifacts("killed");
    ASSERT_LT(reached, all) << "the kill came too late to test anything";
  }
  ASSERT_GT(reached, 0U);
  finish("killed", {4, 1});
  expect_same(expected, test::bake_results(bake("killed")), "killed twice, then four ranks");
}
INSTANTIATE_TEST_SUITE_P(Ways, LbRanks,
                         testing::Values("lb.solver=gather", "lb.solver=photons",
                                         "lb.region_clusters=3", "methods=[lb, sh]"));

}  // namespace
}  // namespace prt
