#include "jobs/coordinator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "graph.h"

namespace prt {
namespace {

using test::content_of;
using test::done;
using test::make_task;
using test::only;

/// A coordinator whose invariants are checked after every event.
class Checked {
 public:
  explicit Checked(KnownContents known = {}, double lease = 0.0)
      : coordinator({{}, lease}, std::move(known)) {}

  std::vector<Command> operator()(const Event& event) {
    auto commands = coordinator.handle(event);
    coordinator.check_invariants();
    return commands;
  }

  Coordinator coordinator;
};

std::vector<std::string> assigned(const std::vector<Command>& commands) {
  std::vector<std::string> ids;
  for (const Assign& a : only<Assign>(commands)) ids.push_back(a.assignment.task.id);
  return ids;
}

TEST(Coordinator, HandsOutTheLongestFirstAndTiesById) {
  Checked c;
  c(WorkerJoined{0, 3});
  const auto commands = c(TasksAdded{{make_task("b", {}, 2), make_task("a", {}, 2),
                                      make_task("long", {}, 9), make_task("short", {}, 1)},
                                     true});
  EXPECT_THAT(assigned(commands), testing::ElementsAre("long", "a", "b"));
}

TEST(Coordinator, WhatOthersWaitForGoesFirst) {
  Checked c;
  c(WorkerJoined{0, 2});
  // "long" ends the work, "begin" is followed by 6 + 3 and "other" by 3; the ends come to nobody.
  const auto commands = c(TasksAdded{
      {make_task("end", {"middle"}, 3), make_task("long", {}, 7), make_task("middle", {"begin"}, 6),
       make_task("begin", {}, 1), make_task("other", {}, 2), make_task("last", {"other"}, 6)},
      true});
  EXPECT_THAT(assigned(commands), testing::ElementsAre("begin", "other"));
}

TEST(Coordinator, GivesWorkToTheFreestWorker) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(WorkerJoined{1, 2});
  const auto commands = c(TasksAdded{{make_task("a"), make_task("b")}, true});
  const auto assigns = only<Assign>(commands);
  ASSERT_EQ(assigns.size(), 2U);
  EXPECT_EQ(assigns[0].worker, 1);
  EXPECT_EQ(assigns[1].worker, 0);
}

/// Which worker got which task.
std::map<std::string, WorkerId> placed(const std::vector<Command>& commands) {
  std::map<std::string, WorkerId> workers;
  for (const Assign& a : only<Assign>(commands)) workers[a.assignment.task.id] = a.worker;
  return workers;
}

/// Two workers, each of which has run the first task of one of the places x and y.
struct TwoPlaces {
  Checked c;
  TwoPlaces() {
    c(WorkerJoined{0, 1});
    c(WorkerJoined{1, 1});
    const auto first = only<Assign>(
        c(TasksAdded{{make_task("x0", {}, 2, "x"), make_task("y0", {}, 1, "y")}, false}));
    EXPECT_EQ(first.size(), 2U);
    EXPECT_EQ(first[0].worker, 0);
    for (const Assign& a : first) c(done(a.worker, a.assignment));
  }
};

TEST(Coordinator, TasksOfAPlaceStayWithTheWorkerThatHoldsIt) {
  TwoPlaces two;
  // Longest first alone would give y1 to worker 0.
  const auto second =
      placed(two.c(TasksAdded{{make_task("x1", {}, 2, "x"), make_task("y1", {}, 3, "y")}, true}));
  EXPECT_EQ(second, (std::map<std::string, WorkerId>{{"x1", 0}, {"y1", 1}}));
}

TEST(Coordinator, ALongerTaskOfNobodysPlaceGoesFirst) {
  TwoPlaces two;
  EXPECT_EQ(placed(two.c(TasksAdded{{make_task("x1", {}, 1, "x"), make_task("y1", {}, 1, "y"),
                                     make_task("a", {}, 4), make_task("b", {}, 3)},
                                    true})),
            (std::map<std::string, WorkerId>{{"a", 0}, {"b", 1}}));
}

TEST(Coordinator, AWorkerTakesItsOwnPlaceAndNobodysBeforeSomebodyElses) {
  TwoPlaces two;
  const auto assigns =
      only<Assign>(two.c(TasksAdded{{make_task("x1", {}, 1, "x"), make_task("y1", {}, 8, "y"),
                                     make_task("y2", {}, 7, "y"), make_task("free", {}, 0.5)},
                                    true}));
  ASSERT_EQ(placed(two.c(Tick{0.0})).size(), 0U);
  ASSERT_EQ(assigned({assigns.begin(), assigns.end()}), (std::vector<std::string>{"x1", "y1"}));
  const auto next = only<Assign>(two.c(done(0, assigns[0].assignment)));
  ASSERT_EQ(assigned({next.begin(), next.end()}), std::vector<std::string>{"free"});
  EXPECT_EQ(assigned(two.c(done(0, next[0].assignment))), std::vector<std::string>{"y2"});
}

TEST(Coordinator, TasksThatAreReadyTogetherGoWithTheFirstOfTheirPlace) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(WorkerJoined{1, 1});
  const auto first = only<Assign>(c(TasksAdded{
      {make_task("x0", {}, 9, "x"), make_task("x1", {}, 8, "x"), make_task("y0", {}, 1, "y")},
      true}));
  EXPECT_EQ(placed({first.begin(), first.end()}),
            (std::map<std::string, WorkerId>{{"x0", 0}, {"y0", 1}}));
  EXPECT_EQ(placed(c(done(0, first[0].assignment))), (std::map<std::string, WorkerId>{{"x1", 0}}));
}

TEST(Coordinator, PlacesOfALostWorkerAreAnybodys) {
  TwoPlaces two;
  two.c(TasksAdded{{make_task("x1", {}, 2, "x"), make_task("y1", {}, 3, "y")}, false});
  two.c(WorkerLost{0});
  EXPECT_EQ(placed(two.c(WorkerJoined{2, 1})), (std::map<std::string, WorkerId>{{"x1", 2}}));
  two.c(Heartbeat{0});  // back, with nothing in memory
  const auto third =
      placed(two.c(TasksAdded{{make_task("x1", {}, 2, "x"), make_task("y1", {}, 3, "y"),
                               make_task("x2", {}, 2, "x"), make_task("z", {}, 1, "z")},
                              true}));
  EXPECT_EQ(third, (std::map<std::string, WorkerId>{{"z", 0}}));
}

TEST(Coordinator, AWorkerThatJoinsAgainHoldsNothing) {
  TwoPlaces two;
  two.c(WorkerJoined{2, 2});
  two.c(WorkerJoined{0, 1});
  // x is as strange to it as to the others, of which one is freer.
  EXPECT_EQ(placed(two.c(TasksAdded{{make_task("x1", {}, 1, "x")}, true})),
            (std::map<std::string, WorkerId>{{"x1", 2}}));
}

TEST(Coordinator, LeasesBeginWithTheFirstTick) {
  Checked c({}, 1.0);
  c(WorkerJoined{0, 1});
  c(Tick{1000.0});
  c(Tick{1000.5});
  EXPECT_TRUE(c.coordinator.lost().empty());
  c(Tick{1002.0});  // judges the silence until 1000.5
  EXPECT_TRUE(c.coordinator.lost().empty());
  c(Tick{1002.1});
  EXPECT_EQ(c.coordinator.lost(), std::vector<WorkerId>{0});
}

TEST(Coordinator, APlaceReachesNoKey) {
  EXPECT_EQ(task_key(make_task("a", {}, 1, "x"), {}, {}), task_key(make_task("a"), {}, {}));
}

TEST(Coordinator, StartsATaskOnlyWhenItsInputsAreDoneAndTellsTheirContents) {
  Checked c;
  c(WorkerJoined{0, 4});
  const auto first = only<Assign>(c(TasksAdded{{make_task("b", {"a"}), make_task("a")}, true}));
  ASSERT_EQ(first.size(), 1U);
  const auto second = only<Assign>(c(done(0, first[0].assignment)));
  ASSERT_EQ(second.size(), 1U);
  const Assignment& b = second[0].assignment;
  ASSERT_EQ(b.inputs.size(), 1U);
  EXPECT_EQ(b.inputs[0].content, content_of(first[0].assignment.key));
  EXPECT_EQ(b.key, task_key(b.task, {b.inputs[0].content}, {}));
}

TEST(Coordinator, SaysStageDoneThenAllDone) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(c(TasksAdded{{make_task("a")}, false}))[0];
  EXPECT_EQ(only<StageDone>(c(done(0, a.assignment))).size(), 1U);
  EXPECT_TRUE(c(Tick{1.0}).empty());  // said once
  const auto b = only<Assign>(c(TasksAdded{{make_task("a"), make_task("b", {"a"})}, true}))[0];
  EXPECT_EQ(only<AllDone>(c(done(0, b.assignment))).size(), 1U);
}

TEST(Coordinator, ACompletePlanWithoutTasksIsDoneAtOnce) {
  Checked c;
  EXPECT_EQ(only<AllDone>(c(TasksAdded{{}, true})).size(), 1U);
}

TEST(Coordinator, PassesOnWhatAnEarlierRunKnew) {
  const TaskSpec a = make_task("a");
  const Digest key = task_key(a, {}, {});
  Checked c(KnownContents{{key, content_of(key)}});
  c(WorkerJoined{0, 1});
  const auto assign = only<Assign>(c(TasksAdded{{a}, true}))[0];
  EXPECT_EQ(assign.assignment.expected, content_of(key));
  const auto record = only<Record>(c(done(0, assign.assignment, true)));
  ASSERT_EQ(record.size(), 1U);
  EXPECT_TRUE(record[0].known);
}

TEST(Coordinator, ASecondReportOfATaskIsHarmless) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(WorkerJoined{1, 1});
  const auto a = only<Assign>(c(TasksAdded{{make_task("a")}, false}))[0];
  EXPECT_EQ(only<Record>(c(done(a.worker, a.assignment))).size(), 1U);
  EXPECT_TRUE(c(done(1, a.assignment)).empty());
}

TEST(Coordinator, TwoResultsForOneKeyStopTheBake) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(c(TasksAdded{{make_task("a")}, false}))[0];
  c(done(0, a.assignment));
  TaskDone other = done(0, a.assignment);
  other.content = hash_text("something else");
  const auto fail = only<Fail>(c(other));
  ASSERT_EQ(fail.size(), 1U);
  EXPECT_THAT(fail[0].message, testing::HasSubstr("determinism"));
  EXPECT_FALSE(fail[0].user_error);
}

TEST(Coordinator, AResultThatDiffersFromTheManifestStopsTheBake) {
  const TaskSpec a = make_task("a");
  const Digest key = task_key(a, {}, {});
  Checked c(KnownContents{{key, hash_text("what it was")}});
  c(WorkerJoined{0, 1});
  const auto assign = only<Assign>(c(TasksAdded{{a}, true}))[0];
  EXPECT_EQ(only<Fail>(c(done(0, assign.assignment))).size(), 1U);
}

TEST(Coordinator, ALostWorkersTasksGoToOthers) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(c(TasksAdded{{make_task("a")}, true}))[0];
  EXPECT_TRUE(assigned(c(WorkerLost{0})).empty());
  const auto again = only<Assign>(c(WorkerJoined{1, 1}));
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].assignment.key, a.assignment.key);
  // The lost one comes back with its result: taken, and the other's is a duplicate.
  EXPECT_EQ(only<AllDone>(c(done(0, a.assignment))).size(), 1U);
  EXPECT_TRUE(c(done(1, a.assignment)).empty());
}

TEST(Coordinator, AWorkerThatJoinsAgainStartsWithNothing) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(TasksAdded{{make_task("a")}, true});
  EXPECT_THAT(assigned(c(WorkerJoined{0, 1})), testing::ElementsAre("a"));
}

TEST(Coordinator, AWorkerThatJoinsAfterTheEndIsSentHome) {
  Checked c;
  c(StopRequested{ExitCode::kInterrupted});
  const auto dismissed = only<Dismiss>(c(WorkerJoined{3, 1}));
  ASSERT_EQ(dismissed.size(), 1U);
  EXPECT_EQ(dismissed[0].worker, 3);
}

TEST(Coordinator, ASilentWorkersLeaseRunsOut) {
  Checked c({}, 10.0);
  c(Tick{100.0});
  c(WorkerJoined{0, 1});
  c(TasksAdded{{make_task("a")}, true});
  c(WorkerJoined{1, 1});
  c(Tick{108.0});
  c(Heartbeat{1});
  EXPECT_TRUE(assigned(c(Tick{110.0})).empty());
  EXPECT_TRUE(assigned(c(Tick{110.5})).empty());
  EXPECT_THAT(assigned(c(Tick{110.6})), testing::ElementsAre("a"));
}

TEST(Coordinator, ItsOwnSilenceIsNotItsWorkers) {
  Checked c({}, 10.0);
  c(Tick{100.0});
  c(WorkerJoined{0, 1});
  c(WorkerJoined{1, 1});
  c(Tick{150.0});   // a disk that did not answer
  c(Heartbeat{1});  // it came meanwhile
  EXPECT_EQ(c.coordinator.ranks().lost, 0);
  c(Tick{150.1});
  EXPECT_THAT(c.coordinator.lost(), testing::ElementsAre(0));
}

TEST(Coordinator, TheFirstTickTakesNobodyForLost) {
  Checked c({}, 10.0);
  c(WorkerJoined{0, 1});
  c(TasksAdded{{make_task("a")}, true});
  c(Tick{5000.0});  // a clock starts anywhere
  EXPECT_EQ(c.coordinator.ranks().lost, 0);
  c(Tick{5010.5});
  c(Tick{5010.6});
  EXPECT_EQ(c.coordinator.ranks().lost, 1);
}

TEST(Coordinator, CountsRanksByWhatTheyDo) {
  Checked c;
  for (const WorkerId id : {0, 1, 2}) c(WorkerJoined{id, 1});
  c(TasksAdded{{make_task("a")}, true});
  c(WorkerLost{2});
  const RankCounts counts = c.coordinator.ranks();
  EXPECT_EQ(counts.busy, 1);
  EXPECT_EQ(counts.idle, 1);
  EXPECT_EQ(counts.lost, 1);
}

TEST(Coordinator, ABadInputIsMadeAgainAndItsReadersWait) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(
      c(TasksAdded{{make_task("a"), make_task("b", {"a"}), make_task("c", {"a"})}, true}))[0];
  const auto b = only<Assign>(c(done(0, a.assignment)))[0];
  EXPECT_EQ(b.assignment.task.id, "b");
  const auto again = only<Assign>(c(InputUnsound{0, "b", "a"}));
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].assignment.task.id, "a");
  EXPECT_EQ(again[0].assignment.expected, content_of(a.assignment.key));
  const auto commands = c(done(0, again[0].assignment));
  EXPECT_TRUE(only<Record>(commands).empty());  // the manifest has it
  EXPECT_THAT(assigned(commands), testing::ElementsAre("b"));
}

TEST(Coordinator, ALateComplaintDoesNotTakeTheTaskFromItsNewWorker) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(
      c(TasksAdded{{make_task("a", {}, 9), make_task("b", {"a"}, 8), make_task("c")}, true}))[0];
  c(done(0, a.assignment));  // worker 0 has b now
  c(WorkerLost{0});
  EXPECT_THAT(assigned(c(WorkerJoined{1, 1})), testing::ElementsAre("b"));
  const auto assigns = only<Assign>(c(InputUnsound{0, "b", "a"}));
  ASSERT_EQ(assigns.size(), 1U) << "worker 1 is busy";
  EXPECT_EQ(assigns[0].worker, 0);
  EXPECT_EQ(assigns[0].assignment.task.id, "a");
}

TEST(Coordinator, AFailureOfATaskThatAnotherHasDoneIsNoFailure) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(c(TasksAdded{{make_task("a"), make_task("b")}, true}))[0];
  c(WorkerLost{0});
  const auto again = only<Assign>(c(WorkerJoined{1, 1}))[0];
  c(done(1, again.assignment));
  EXPECT_TRUE(only<Fail>(c(TaskFailed{0, a.assignment.task.id, "no memory left", false})).empty());
  EXPECT_TRUE(c.coordinator.result(a.assignment.task.id).has_value());
}

TEST(Coordinator, GivesUpOnAnInputThatNeverReads) {
  Checked c;
  c(WorkerJoined{0, 1});
  auto commands = c(TasksAdded{{make_task("a"), make_task("b", {"a"})}, true});
  for (int round = 0; only<Fail>(commands).empty(); ++round) {
    ASSERT_LT(round, 10);
    const auto assign = only<Assign>(commands).at(0);
    const bool is_a = assign.assignment.task.id == "a";
    commands = is_a ? c(done(0, assign.assignment)) : c(InputUnsound{0, "b", "a"});
  }
  EXPECT_THAT(only<Fail>(commands)[0].message, testing::HasSubstr("disk"));
}

TEST(Coordinator, TheOrderOfPlanningCanComeBackForABadResult) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(c(TasksAdded{{make_task("a")}, false}))[0];
  c(done(0, a.assignment));
  const auto again = only<Assign>(c(ResultUnsound{"a"}));
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(only<StageDone>(c(done(0, again[0].assignment))).size(), 1U);
}

TEST(Coordinator, AFailedTaskEndsTheBakeWithItsMessage) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(TasksAdded{{make_task("a"), make_task("b")}, true});
  const auto commands = c(TaskFailed{0, "a", "room.glb: no free space; move samples.start", true});
  ASSERT_EQ(only<Fail>(commands).size(), 1U);
  EXPECT_TRUE(only<Fail>(commands)[0].user_error);
  EXPECT_EQ(only<Fail>(commands)[0].message, "room.glb: no free space; move samples.start");
  EXPECT_TRUE(assigned(commands).empty());
}

TEST(Coordinator, StoppingDismissesEverybodyAndHandsOutNothing) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(WorkerJoined{1, 1});
  const auto a =
      only<Assign>(c(TasksAdded{{make_task("a"), make_task("b"), make_task("c")}, true}))[0];
  EXPECT_EQ(only<Dismiss>(c(StopRequested{ExitCode::kInterrupted})).size(), 2U);
  const auto commands = c(done(a.worker, a.assignment));
  EXPECT_EQ(only<Record>(commands).size(), 1U);  // late results still count
  EXPECT_TRUE(only<Assign>(commands).empty());
}

TEST(Coordinator, DrainingLetsRunningTasksEndAndStartsNone) {
  Checked c;
  c(WorkerJoined{0, 2});
  const auto running =
      only<Assign>(c(TasksAdded{{make_task("a"), make_task("b"), make_task("c")}, false}));
  ASSERT_EQ(running.size(), 2U);
  EXPECT_TRUE(c(DrainRequested{}).empty());
  EXPECT_TRUE(c(WorkerJoined{1, 1}).empty()) << "a late rank gets nothing";
  const auto first = c(done(0, running[0].assignment));
  EXPECT_EQ(only<Record>(first).size(), 1U);
  EXPECT_TRUE(only<Assign>(first).empty());
  EXPECT_TRUE(only<Drained>(first).empty());
  c(DrainRequested{});  // every rank hears the signal
  EXPECT_EQ(only<Drained>(c(done(0, running[1].assignment))).size(), 1U);
  EXPECT_TRUE(c(DrainRequested{}).empty());
}

TEST(Coordinator, DrainingWithNothingRunningEndsAtOnce) {
  Checked c;
  c(WorkerJoined{0, 1});
  EXPECT_EQ(only<Drained>(c(DrainRequested{})).size(), 1U);
}

TEST(Coordinator, DrainingDoesNotWaitForALostRank) {
  Checked c;
  c(WorkerJoined{0, 1});
  c(TasksAdded{{make_task("a")}, true});
  c(DrainRequested{});
  EXPECT_EQ(only<Drained>(c(WorkerLost{0})).size(), 1U);
}

TEST(Coordinator, ATaskWhoseArtifactWasLetGoIsDoneUntilSomebodyReadsIt) {
  const TaskSpec a = make_task("a");
  const Digest key = task_key(a, {}, {});
  Coordinator c({{}, 0.0, {key}}, {{key, content_of(key)}});
  (void)c.handle(WorkerJoined{0, 1});
  const auto b = only<Assign>(c.handle(TasksAdded{{a, make_task("b", {"a"})}, true})).at(0);
  EXPECT_EQ(b.assignment.task.id, "b");
  const auto again = only<Assign>(c.handle(InputUnsound{0, "b", "a"}));
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].assignment.task.id, "a");
  c.check_invariants();
}

TEST(Coordinator, RefusesBrokenPlans) {
  const auto fails = [](std::vector<TaskSpec> tasks) {
    Coordinator c({}, {});
    return only<Fail>(c.handle(TasksAdded{std::move(tasks), true})).size() == 1;
  };
  EXPECT_TRUE(fails({make_task("a", {"nobody"})}));
  EXPECT_TRUE(fails({make_task("a", {"b"}), make_task("b", {"a"})}));
  EXPECT_TRUE(fails({make_task("a", {"a"})}));
  TaskSpec other = make_task("a");
  other.parameters["more"] = 1;
  EXPECT_TRUE(fails({make_task("a"), other}));
}

TEST(Coordinator, CountsProgressByStage) {
  Checked c;
  c(WorkerJoined{0, 1});
  const auto a = only<Assign>(c(
      TasksAdded{{make_task("rays/0", {}, 2), make_task("rays/1"), make_task("pca/0")}, true}))[0];
  c(done(0, a.assignment, true));
  const auto progress = c.coordinator.progress();
  ASSERT_EQ(progress.size(), 2U);
  EXPECT_EQ(progress[0].first, "rays");
  EXPECT_EQ(progress[0].second.total, 2U);
  EXPECT_EQ(progress[0].second.done, 1U);
  EXPECT_EQ(progress[0].second.adopted, 1U);
  EXPECT_DOUBLE_EQ(progress[0].second.cost_done, 2.0);
  EXPECT_EQ(c.coordinator.undone(), 2U);
}

}  // namespace
}  // namespace prt
