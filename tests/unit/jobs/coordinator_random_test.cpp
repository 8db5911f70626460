// Random graphs, worked off by workers that die, come back, repeat themselves, answer late and in
// any order, and find artifacts broken. Whatever happens: the invariants hold between any two
// events, every task is done in the end with the keys and contents a single undisturbed worker
// gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>

#include "graph.h"

namespace prt {
namespace {

using test::content_of;
using test::done;
using test::make_task;

constexpr int kGraphs = 400;
/// Far above what any of these graphs needs: a bake that does not end is an error, not a hang.
constexpr int kMostEvents = 100'000;

using Rng = std::mt19937;

int pick(Rng& rng, int most) { return std::uniform_int_distribution<int>(0, most)(rng); }

/// Tasks of up to four stages; each reads some of those before it.
std::vector<std::vector<TaskSpec>> random_stages(Rng& rng) {
  std::vector<std::vector<TaskSpec>> stages(1 + pick(rng, 3));
  std::vector<std::string> made;
  for (std::size_t s = 0; s < stages.size(); ++s) {
    const int count = pick(rng, 12);
    for (int i = 0; i < count; ++i) {
      std::vector<std::string> inputs;
      for (int k = pick(rng, 3); k > 0 && !made.empty(); --k) {
        const std::string& input = made[pick(rng, static_cast<int>(made.size()) - 1)];
        if (std::ranges::find(inputs, input) == inputs.end()) inputs.push_back(input);
      }
      const std::string id = "stage" + std::to_string(s) + "/" + std::to_string(i);
      stages[s].push_back(make_task(id, inputs, pick(rng, 3)));
      made.push_back(id);
    }
    std::ranges::shuffle(stages[s], rng);
  }
  return stages;
}

/// Contents by task id, computed without the coordinator.
std::map<std::string, Digest> expected_contents(const std::vector<std::vector<TaskSpec>>& stages) {
  std::map<std::string, TaskSpec> open;
  for (const auto& stage : stages) {
    for (const TaskSpec& task : stage) open.emplace(task.id, task);
  }
  std::map<std::string, Digest> contents;
  while (!open.empty()) {
    for (auto it = open.begin(); it != open.end();) {
      std::vector<Digest> inputs;
      for (const std::string& id : it->second.inputs) {
        if (contents.contains(id)) inputs.push_back(contents.at(id));
      }
      const bool ready = inputs.size() == it->second.inputs.size();
      if (ready) contents[it->first] = content_of(task_key(it->second, inputs, {}));
      it = ready ? open.erase(it) : std::next(it);
    }
  }
  return contents;
}

class Simulation {
 public:
  explicit Simulation(unsigned seed)
      : rng_(seed), stages_(random_stages(rng_)), c_({{}, 50.0}, {}) {}

  void run() {
    join();
    plan();
    for (int i = 0; !all_done_; ++i) {
      ASSERT_LT(i, kMostEvents) << "the bake does not end";
      step();
      if (HasFatalFailure()) return;
    }
    for (const auto& [id, content] : expected_contents(stages_)) {
      const auto result = c_.result(id);
      ASSERT_TRUE(result.has_value()) << id;
      EXPECT_EQ(result->content, content) << id;
      EXPECT_EQ(records_[id], 1) << id << " must be recorded once";
    }
  }

  static bool HasFatalFailure() { return testing::Test::HasFatalFailure(); }

 private:
  struct Running {
    WorkerId worker;
    Assignment assignment;
  };

  void feed(const Event& event) {
    std::vector<Command> commands = c_.handle(event);
    ASSERT_NO_THROW(c_.check_invariants());
    bool stage_done = false;
    for (const Command& command : commands) {
      if (const auto* a = std::get_if<Assign>(&command)) {
        running_.push_back({a->worker, a->assignment});
        ++assigned_;
      } else if (const auto* r = std::get_if<Record>(&command)) {
        ++records_[r->done.task];
      } else if (const auto* f = std::get_if<Fail>(&command)) {
        FAIL() << f->message;
      } else {
        stage_done |= std::holds_alternative<StageDone>(command);
        all_done_ |= std::holds_alternative<AllDone>(command);
      }
    }
    if (stage_done) plan();
  }

  void plan() {
    std::vector<TaskSpec> tasks;
    for (std::size_t s = 0; s <= planned_; ++s) {
      tasks.insert(tasks.end(), stages_[s].begin(), stages_[s].end());
    }
    const bool last = ++planned_ == stages_.size();
    feed(TasksAdded{tasks, last});
  }

  void join() { feed(WorkerJoined{next_worker_++, 1 + pick(rng_, 2)}); }

  Running take_any() {
    const auto it = running_.begin() + pick(rng_, static_cast<int>(running_.size()) - 1);
    Running r = *it;
    running_.erase(it);
    return r;
  }

  void step() {
    now_ += 1.0;
    feed(Tick{now_});
    for (WorkerId w = 0; w < next_worker_; ++w) {
      if (!mute_.contains(w)) feed(Heartbeat{w});
    }
    const int dice = pick(rng_, 99);
    if (dice < 4) {
      join();
    } else if (dice < 8) {
      feed(WorkerLost{pick(rng_, next_worker_)});
    } else if (dice < 10) {
      mute_.insert(pick(rng_, next_worker_ - 1));
    } else if (dice < 14 && !finished_.empty()) {
      feed(finished_[pick(rng_, static_cast<int>(finished_.size()) - 1)]);
    } else if (dice < 18) {
      distrust();
    } else if (!running_.empty()) {
      finish();
    } else {
      join();
    }
  }

  void finish() {
    const Running r = take_any();
    const TaskDone report = done(r.worker, r.assignment, pick(rng_, 3) == 0);
    finished_.push_back(report);
    feed(report);
  }

  void distrust() {
    if (running_.empty()) return;
    const Running r = take_any();
    // Each task distrusts at most once, so that no disk looks broken for good.
    if (r.assignment.inputs.empty() || !distrusted_.insert(r.assignment.task.id).second) {
      running_.push_back(r);
      return;
    }
    const int input = pick(rng_, static_cast<int>(r.assignment.inputs.size()) - 1);
    feed(InputUnsound{r.worker, r.assignment.task.id, r.assignment.inputs[input].id});
  }

  Rng rng_;
  std::vector<std::vector<TaskSpec>> stages_;
  Coordinator c_;
  std::size_t planned_ = 0;
  WorkerId next_worker_ = 0;
  double now_ = 0.0;
  bool all_done_ = false;
  int assigned_ = 0;
  std::vector<Running> running_;
  std::vector<TaskDone> finished_;
  std::set<WorkerId> mute_;
  std::set<std::string> distrusted_;
  std::map<std::string, int> records_;
};

TEST(CoordinatorRandom, EveryDisturbedBakeGivesTheUndisturbedResult) {
  for (unsigned seed = 0; seed < kGraphs && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Simulation(seed).run();
  }
}

}  // namespace
}  // namespace prt
