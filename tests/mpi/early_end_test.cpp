// Bakes that end early under real mpirun: failing tasks and signals leave a bake that can be
// resumed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "toy_runs.h"

namespace prt {
namespace {

using test::count;
using test::kSlowTask;
using test::kTasks;
using test::log_of;
using test::run;
using test::ToyFolder;
using test::ToyRun;

/// A signalled bake has to be gone within a second (design §5); start-up and mpirun's own clearing
/// up come on top.
constexpr std::chrono::seconds kGoneWithin{5};

TEST(EarlyEnd, AFailingTaskEndsTheBakeWithItsCode) {
  struct Case {
    const char* kind;
    int code;
    const char* message;
  };
  for (const Case& c : {Case{"user", 2, "mend it"}, Case{"memory", 1, "out of memory"},
                        Case{"bug", 1, "a bug in the toy"}}) {
    // Two ranks once: what a task throws is turned into a message before ranks come into it.
    for (const int ranks : c.code == 2 ? std::vector{0, 2} : std::vector{0}) {
      const ToyFolder folder;
      const ToyRun failing{
          ranks, 1, {}, {{"PRT_TOY_FAIL", "leaf/0017"}, {"PRT_TOY_FAIL_KIND", c.kind}}};
      EXPECT_EQ(run(folder, failing), c.code) << log_of(folder);
      EXPECT_THAT(log_of(folder), testing::HasSubstr(c.message));
      EXPECT_EQ(count(log_of(folder), "prt_bake: "), 1U) << log_of(folder);
      EXPECT_FALSE(std::filesystem::exists(folder.bake() / "complete.json"));
      ASSERT_EQ(run(folder, {ranks, 1}), 0) << log_of(folder);
    }
  }
}

TEST(EarlyEnd, SignalsLeaveAResumableBake) {
  const ToyFolder undisturbed;
  ASSERT_EQ(run(undisturbed, {}), 0);
  for (const int ranks : {0, 2}) {
    const std::vector alone{SIGTERM, SIGINT, SIGUSR1};
    const std::vector under_mpirun{SIGTERM, SIGUSR1};  // mpirun turns SIGINT into SIGTERM
    for (const int signal : ranks == 0 ? alone : under_mpirun) {
      const ToyFolder folder;
      const auto program =
          folder.start({ranks, 1, {}, {{"PRT_TOY_SPIN_US", kSlowTask}}}, PRT_MPIRUN);
      while (folder.count_artifacts() == 0 && !program->finished()) std::this_thread::yield();
      const auto began = std::chrono::steady_clock::now();
      program->send(signal);
      const int code = program->wait();
      EXPECT_LT(std::chrono::steady_clock::now() - began, kGoneWithin);
      // mpirun itself answers SIGINT and SIGTERM with codes of its own.
      if (ranks == 0 || signal == SIGUSR1) {
        EXPECT_EQ(code, 3) << log_of(folder);
      }
      EXPECT_LT(folder.count_artifacts(), kTasks);
      EXPECT_FALSE(std::filesystem::exists(folder.bake() / "complete.json"));
      ASSERT_EQ(run(folder, {ranks, 1}), 0) << log_of(folder);
      EXPECT_EQ(folder.results(), undisturbed.results());
    }
  }
}

}  // namespace
}  // namespace prt
