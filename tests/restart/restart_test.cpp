// Nothing is lost: a bake killed with SIGKILL at random moments, all processes at once, and resumed
// again and again, ends with the bytes of an undisturbed one. Each kill is checked to have struck
// while tasks were undone.
#include <gtest/gtest.h>

#include <random>

#include "support/program.h"

namespace prt {
namespace {

using test::ToyFolder;
using test::ToyRun;

constexpr std::size_t kTasks = 61;
constexpr int kKills = 4;
/// Tasks of 5 ms: a bake takes a few tenths of a second, and kills hit every phase of it.
const std::string kTask = "5000";

class Restart : public testing::TestWithParam<int> {};

/// Kills the job once `artifacts` are on disk; true if it struck before the end.
bool kill_at(const ToyFolder& folder, const ToyRun& run, std::size_t artifacts) {
  const auto program = folder.start(run, PRT_MPIRUN);
  while (folder.count_artifacts() < artifacts && !program->finished()) std::this_thread::yield();
  if (program->finished()) return false;
  program->kill_all();
  return folder.count_artifacts() < kTasks;
}

TEST_P(Restart, KilledAndResumedGivesTheUndisturbedBytes) {
  const int ranks = GetParam();
  const ToyFolder gold;
  ASSERT_EQ(gold.start({}, PRT_MPIRUN)->wait(), 0);

  std::mt19937 rng(static_cast<unsigned>(ranks) + 1);
  const ToyFolder silver;
  const ToyRun run{ranks, 1, {}, {{"PRT_TOY_SPIN_US", kTask}}};
  int struck = 0;
  std::size_t reached = 0;
  for (int i = 0; i < kKills; ++i) {
    const std::size_t most = kTasks - 1 - static_cast<std::size_t>(2 * (kKills - i));
    const std::size_t at = std::uniform_int_distribution<std::size_t>(
        reached, std::min(most, reached + kTasks / kKills))(rng);
    struck += kill_at(silver, run, at) ? 1 : 0;
    EXPECT_FALSE(std::filesystem::exists(silver.bake() / "complete.json"));
    EXPECT_GE(silver.count_artifacts(), reached) << "a finished task was lost";
    reached = silver.count_artifacts();
  }
  EXPECT_EQ(struck, kKills) << "a kill came too late to test anything";
  ASSERT_LT(reached, kTasks);

  const auto last = silver.start({ranks, 1}, PRT_MPIRUN);
  ASSERT_EQ(last->wait(), 0) << last->output();
  EXPECT_EQ(silver.results(), gold.results());
  EXPECT_NE(last->output().find(" found, "), std::string::npos);
  EXPECT_EQ(last->output().find(" 0 found, "), std::string::npos) << "nothing was resumed";
}

INSTANTIATE_TEST_SUITE_P(Ranks, Restart, testing::Values(0, 1, 2, 4));

TEST(Restart, AResumeWithOtherRanksGivesTheSameBytes) {
  const ToyFolder gold;
  ASSERT_EQ(gold.start({}, PRT_MPIRUN)->wait(), 0);
  const ToyFolder silver;
  ASSERT_TRUE(kill_at(silver, {4, 1, {}, {{"PRT_TOY_SPIN_US", kTask}}}, 10));
  ASSERT_TRUE(kill_at(silver, {0, 2, {}, {{"PRT_TOY_SPIN_US", kTask}}}, 30));
  ASSERT_EQ(silver.start({2, 2}, PRT_MPIRUN)->wait(), 0);
  EXPECT_EQ(silver.results(), gold.results());
}

}  // namespace
}  // namespace prt
