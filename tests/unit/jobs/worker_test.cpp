#include "jobs/worker.h"

#include <gtest/gtest.h>

#include "graph.h"

namespace prt {
namespace {

Assignment assignment(const std::string& id) {
  const TaskSpec task = test::make_task(id);
  return {task, task_key(task, {}, {}), std::nullopt, {}};
}

template <typename T>
std::vector<T> only_actions(const std::vector<WorkerAction>& actions) {
  std::vector<T> found;
  for (const WorkerAction& action : actions) {
    if (const auto* a = std::get_if<T>(&action)) found.push_back(*a);
  }
  return found;
}

TEST(Worker, RunsAsManyTasksAsItHasSlots) {
  Worker worker(3, 2);
  EXPECT_EQ(worker.join().slots, 2);
  EXPECT_EQ(only_actions<Start>(worker.handle(Order{assignment("a")})).at(0).slot, 0);
  EXPECT_EQ(only_actions<Start>(worker.handle(Order{assignment("b")})).at(0).slot, 1);
  EXPECT_TRUE(worker.handle(Order{assignment("c")}).empty());
  Outcome outcome;
  outcome.content = hash_text("b");
  const auto actions = worker.handle(SlotFinished{1, outcome});
  const auto report = std::get<TaskDone>(only_actions<Report>(actions).at(0).event);
  EXPECT_EQ(report.task, "b");
  EXPECT_EQ(report.worker, 3);
  EXPECT_EQ(report.content, hash_text("b"));
  EXPECT_EQ(only_actions<Start>(actions).at(0).assignment.task.id, "c");
}

TEST(Worker, IgnoresATaskItHasAlready) {
  Worker worker(0, 2);
  (void)worker.handle(Order{assignment("a")});
  EXPECT_TRUE(worker.handle(Order{assignment("a")}).empty());
}

TEST(Worker, ReportsFailuresAndBadInputsButNotDroppedTasks) {
  Worker worker(1, 1);
  (void)worker.handle(Order{assignment("a")});
  Outcome failed;
  failed.kind = Outcome::Kind::kFailed;
  failed.message = "out of memory";
  auto reports = only_actions<Report>(worker.handle(SlotFinished{0, failed}));
  EXPECT_EQ(std::get<TaskFailed>(reports.at(0).event).message, "out of memory");
  (void)worker.handle(Order{assignment("a")});
  Outcome unsound;
  unsound.kind = Outcome::Kind::kInputUnsound;
  unsound.input = "rays/0";
  reports = only_actions<Report>(worker.handle(SlotFinished{0, unsound}));
  EXPECT_EQ(std::get<InputUnsound>(reports.at(0).event).input, "rays/0");
  (void)worker.handle(Order{assignment("a")});
  Outcome dropped;
  dropped.kind = Outcome::Kind::kDropped;
  EXPECT_TRUE(worker.handle(SlotFinished{0, dropped}).empty());
}

TEST(Worker, LeavesWhenDismissedAndTakesNothingAfterwards) {
  Worker worker(1, 1);
  const auto actions = worker.handle(Order{Dismissed{ExitCode::kBadInput}});
  EXPECT_EQ(only_actions<Leave>(actions).at(0).code, ExitCode::kBadInput);
  EXPECT_TRUE(worker.handle(Order{assignment("a")}).empty());
}

TEST(Worker, StartsNothingThatWaitedOnceItIsDismissed) {
  Worker worker(1, 1);
  (void)worker.handle(Order{assignment("a")});
  (void)worker.handle(Order{assignment("b")});
  (void)worker.handle(Order{Dismissed{ExitCode::kInterrupted}});
  Outcome dropped;
  dropped.kind = Outcome::Kind::kDropped;
  EXPECT_TRUE(worker.handle(SlotFinished{0, dropped}).empty());
}

TEST(Worker, TellsThatItIsAlive) {
  Worker worker(1, 1, 5.0);
  EXPECT_EQ(only_actions<Report>(worker.handle(Tick{10.0})).size(), 1U);
  EXPECT_TRUE(worker.handle(Tick{14.0}).empty());
  EXPECT_EQ(only_actions<Report>(worker.handle(Tick{15.0})).size(), 1U);
}

TEST(Worker, LeavesWhenItsCoordinatorIsSilentForTooLong) {
  Worker worker(1, 1, 0.0, 20.0);
  EXPECT_TRUE(worker.handle(Tick{1000.0}).empty());
  EXPECT_TRUE(worker.handle(Tick{1019.0}).empty());
  EXPECT_TRUE(worker.handle(Order{StillHere{}}).empty());
  EXPECT_TRUE(worker.handle(Tick{1039.5}).empty());
  const auto actions = worker.handle(Tick{1039.6});
  EXPECT_EQ(only_actions<Leave>(actions).at(0).code, ExitCode::kInterrupted);
  EXPECT_TRUE(worker.handle(Order{assignment("a")}).empty());
}

}  // namespace
}  // namespace prt
