#include "jobs/slots.h"

#include <gtest/gtest.h>

#include <functional>
#include <new>

#include "graph.h"
#include "jobs/service.h"

namespace prt {
namespace {

using namespace std::chrono_literals;

/// Longer than any of these tasks takes, so that a lost wake-up shows as a failed test.
constexpr auto kLongWait = 20s;

class LambdaRunner : public TaskRunner {
 public:
  using Body = std::function<Made(const Assignment&, const std::atomic<bool>&)>;
  explicit LambdaRunner(Body body) : body_(std::move(body)) {}
  Made run(const Assignment& a, const std::atomic<bool>& stop) override { return body_(a, stop); }

 private:
  Body body_;
};

Assignment assignment(const std::string& id) {
  const TaskSpec task = test::make_task(id);
  return {task, task_key(task, {}, {}), std::nullopt, {}};
}

Outcome guarded(const LambdaRunner::Body& body) {
  LambdaRunner runner(body);
  const std::atomic<bool> stop = false;
  return run_guarded(runner, assignment("a"), 0, stop);
}

TEST(TaskBoundary, TurnsWhateverIsThrownIntoAnOutcome) {
  using Made = TaskRunner::Made;
  const auto user = guarded([](auto&, auto&) -> Made { throw UserError("no light fits"); });
  EXPECT_EQ(user.kind, Outcome::Kind::kFailed);
  EXPECT_TRUE(user.user_error);
  EXPECT_EQ(user.message, "no light fits");
  const auto memory = guarded([](auto&, auto&) -> Made { throw std::bad_alloc(); });
  EXPECT_FALSE(memory.user_error);
  EXPECT_NE(memory.message.find("memory"), std::string::npos);
  EXPECT_EQ(guarded([](auto&, auto&) -> Made { throw 3; }).kind, Outcome::Kind::kFailed);
  EXPECT_EQ(guarded([](auto&, auto&) -> Made { throw Interrupted("stop"); }).kind,
            Outcome::Kind::kDropped);
  const auto input = guarded([](auto&, auto&) -> Made { throw InputDistrusted("rays/3", "bad"); });
  EXPECT_EQ(input.kind, Outcome::Kind::kInputUnsound);
  EXPECT_EQ(input.input, "rays/3");
}

TEST(Slots, AFinishedTaskWakesTheWaitingThread) {
  LambdaRunner runner([](auto&, auto&) { return TaskRunner::Made{hash_text("x"), false, 1}; });
  Slots slots(2, runner);
  slots.start(0, assignment("a"));
  slots.wait(kLongWait);
  const auto finished = slots.take_finished();
  ASSERT_EQ(finished.size(), 1U);
  EXPECT_EQ(finished[0].outcome.content, hash_text("x"));
  EXPECT_TRUE(slots.idle());
}

TEST(Slots, DestructionStopsATaskThatPolls) {
  std::atomic<bool> began = false;
  LambdaRunner runner([&](auto&, const std::atomic<bool>& stop) -> TaskRunner::Made {
    began = true;
    while (!stop) std::this_thread::yield();
    throw Interrupted("stop");
  });
  Slots slots(1, runner);
  slots.start(0, assignment("a"));
  while (!began) std::this_thread::yield();
  EXPECT_FALSE(slots.idle());
}

/// A host with two stages of tasks.
class TwoStages : public BakeHost {
 public:
  void record(const Record& record) override { recorded.push_back(record.done.task); }
  Event plan_on(const Coordinator&) override {
    TasksAdded added;
    for (int i = 0; i < 5; ++i) added.tasks.push_back(test::make_task("a/" + std::to_string(i)));
    if (++plans == 1) return added;
    for (int i = 0; i < 5; ++i) {
      added.tasks.push_back(test::make_task("b/" + std::to_string(i), {"a/0", "a/1"}));
    }
    added.last = true;
    return added;
  }
  std::optional<Event> finish(const Coordinator&) override {
    if (++finishes == 1) return ResultUnsound{"b/3"};
    return std::nullopt;
  }
  void tick(const Coordinator&, double) override {}

  int plans = 0;
  int finishes = 0;
  std::vector<std::string> recorded;
};

TEST(Service, OneRankRunsAWholeBake) {
  LambdaRunner runner([](const Assignment& a, auto&) {
    return TaskRunner::Made{test::content_of(a.key), false, 1};
  });
  for (const int threads : {1, 3}) {
    Slots slots(threads, runner);
    Coordinator coordinator({}, {});
    TwoStages host;
    NoLink link;
    const LoopEnd end = run_coordinator(coordinator, host, link, slots, {});
    EXPECT_EQ(end.code, ExitCode::kDone);
    EXPECT_EQ(host.finishes, 2);  // b/3 was made again
    EXPECT_EQ(host.recorded.size(), 10U);
    EXPECT_EQ(coordinator.undone(), 0U);
  }
}

TEST(Service, AFailureEndsTheLoopWithItsMessage) {
  LambdaRunner runner([](auto&, auto&) -> TaskRunner::Made { throw UserError("move the start"); });
  Slots slots(1, runner);
  Coordinator coordinator({}, {});
  TwoStages host;
  NoLink link;
  const LoopEnd end = run_coordinator(coordinator, host, link, slots, {});
  EXPECT_EQ(end.code, ExitCode::kBadInput);
  EXPECT_EQ(end.message, "move the start");
}

TEST(Service, AStopFlagEndsTheLoopAsInterrupted) {
  LambdaRunner runner([](auto&, const std::atomic<bool>& stop) -> TaskRunner::Made {
    while (!stop) std::this_thread::yield();
    throw Interrupted("stop");
  });
  Slots slots(1, runner);
  Coordinator coordinator({}, {});
  TwoStages host;
  NoLink link;
  const std::atomic<bool> stop = true;
  ServiceSettings settings;
  settings.stop = &stop;
  EXPECT_EQ(run_coordinator(coordinator, host, link, slots, settings).code, ExitCode::kInterrupted);
}

}  // namespace
}  // namespace prt
