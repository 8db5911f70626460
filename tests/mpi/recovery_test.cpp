// Under mpirun --enable-recovery a rank that dies or hangs costs its running tasks and nothing
// else, and a slow disk costs none; after SIGUSR1 running tasks end before the bake does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "toy_runs.h"

namespace prt {
namespace {

using test::log_of;
using test::Program;
using test::ToyFolder;
using test::ToyRun;

/// Long enough for a loaded machine to speak in time, short enough for a test.
constexpr const char* kLease = "jobs.lease=1.5";
/// Microseconds: 61 such tasks on three ranks last longer than a lease runs.
const std::string kTask = "200000";
constexpr std::size_t kStrikeAt = 5;

/// Process of one rank of the job below `root`, or 0 while there is none.
pid_t process_of_rank(pid_t root, int rank) {
  const std::string wanted = "OMPI_COMM_WORLD_RANK=" + std::to_string(rank);
  for (const pid_t process : test::process_tree(root)) {
    std::istringstream environment(
        test::read_text("/proc/" + std::to_string(process) + "/environ"));
    for (std::string variable; std::getline(environment, variable, '\0');) {
      if (variable == wanted) return process;
    }
  }
  return 0;
}

ToyRun three_ranks() {
  return {3, 1, {"--set", kLease}, {{"PRT_TOY_SPIN_US", kTask}}, {"--enable-recovery"}};
}

class Recovery : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run(undisturbed_, {}), 0);
    program_ = folder_.start(three_ranks(), PRT_MPIRUN);
    while (folder_.count_artifacts() < kStrikeAt && !program_->finished()) {
      std::this_thread::yield();
    }
    ASSERT_FALSE(program_->finished()) << program_->output();
    victim_ = process_of_rank(program_->process(), 2);
    ASSERT_GT(victim_, 0);
  }
  void expect_the_undisturbed_bytes() {
    // mpirun's exit code says nothing here: the marker on disk does.
    EXPECT_TRUE(std::filesystem::exists(folder_.bake() / "complete.json")) << program_->output();
    EXPECT_EQ(folder_.results(), undisturbed_.results());
    // One that the victim had written and not yet told of is found, not made again.
    EXPECT_THAT(program_->output(), testing::AnyOf(testing::HasSubstr("61 tasks made, 0 found"),
                                                   testing::HasSubstr("60 tasks made, 1 found")));
  }

  ToyFolder undisturbed_, folder_;
  std::unique_ptr<Program> program_;
  pid_t victim_ = 0;
};

TEST_F(Recovery, AKilledRankCostsItsRunningTaskAlone) {
  kill(victim_, SIGKILL);
  // What it was writing.
  std::ofstream(folder_.bake() / "artifacts/leaf/0.h5.1.2.tmp") << "half a file";
  program_->wait();
  EXPECT_THAT(program_->output(), testing::HasSubstr("1 rank(s) are silent"));
  expect_the_undisturbed_bytes();
}

TEST_F(Recovery, AHungRankIsGivenUpAndDoesNotHoldTheEnd) {
  kill(victim_, SIGSTOP);
  program_->wait();
  EXPECT_THAT(program_->output(), testing::HasSubstr("1 rank(s) are silent"));
  expect_the_undisturbed_bytes();
  EXPECT_NE(kill(victim_, 0), 0) << "the hung rank outlived its job";
}

TEST_F(Recovery, ARankThatWakesUpLateIsTakenBack) {
  kill(victim_, SIGSTOP);
  while (program_->output().find("silent") == std::string::npos && !program_->finished()) {
    std::this_thread::yield();
  }
  ASSERT_FALSE(program_->finished()) << program_->output();
  kill(victim_, SIGCONT);
  program_->wait();
  expect_the_undisturbed_bytes();
}

TEST(SlowDisk, TakesNobodyForLost) {
  const ToyFolder undisturbed;
  ASSERT_EQ(run(undisturbed, {}), 0);
  const ToyFolder folder;
  // Each sync of the manifest keeps the coordinator from listening for longer than a lease.
  EXPECT_EQ(run(folder, {2,
                         1,
                         {"--set", "jobs.lease=0.5"},
                         {{"PRT_TOY_SPIN_US", "50000"}, {"PRT_TOY_SLOW_SYNC_MS", "800"}}}),
            0);
  EXPECT_THAT(log_of(folder), testing::Not(testing::HasSubstr("silent")));
  EXPECT_THAT(log_of(folder), testing::HasSubstr("61 tasks made, 0 found"));
  EXPECT_EQ(folder.results(), undisturbed.results());
}

TEST(Drain, RunningTasksEndAndTheBakeIsResumable) {
  const ToyFolder undisturbed;
  ASSERT_EQ(run(undisturbed, {}), 0);
  for (const int ranks : {0, 2}) {
    const ToyFolder folder;
    const auto program = folder.start({ranks, 1, {}, {{"PRT_TOY_SPIN_US", kTask}}}, PRT_MPIRUN);
    // Once two results are written down, every rank has been given its next task.
    const auto recorded = [&] {
      return test::count(test::read_text(folder.bake() / "manifest.log"), "\"task\"");
    };
    while (recorded() < 2 && !program->finished()) std::this_thread::yield();
    program->send(SIGUSR1);
    EXPECT_EQ(program->wait(), 3) << program->output();
    const std::size_t kept = folder.count_artifacts();
    EXPECT_LT(kept, test::kTasks);
    EXPECT_GE(kept, 2U + static_cast<std::size_t>(std::max(1, ranks))) << "a running task was lost";
    ASSERT_EQ(run(folder, {ranks, 1}), 0);
    EXPECT_EQ(folder.results(), undisturbed.results());
  }
}

TEST(Drain, TheGraceIsBounded) {
  const ToyFolder folder;
  const auto program = folder.start(
      {0, 1, {"--set", "jobs.grace=0.2"}, {{"PRT_TOY_SPIN_US", "60000000"}}}, PRT_MPIRUN);
  while (!std::filesystem::exists(folder.bake() / "progress.json") && !program->finished()) {
    std::this_thread::yield();
  }
  program->send(SIGUSR1);
  EXPECT_EQ(program->wait(), 3) << program->output();
  EXPECT_EQ(folder.count_artifacts(), 0U);
}

}  // namespace
}  // namespace prt
