// Random graphs, worked off by workers that die, come back, repeat themselves, answer late and in
// any order, and find artifacts broken or let go, in jobs that are killed or drained and started
// again from what is on the disk. Whatever happens: the invariants hold between any two events,
// every task is done in the end with the keys and contents a single undisturbed worker gives, and
// none is made again without a reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "graph.h"

namespace prt {
namespace {

using test::content_of;
using test::done;
using test::make_task;

constexpr int kGraphs = 2000;
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
      const std::string place = pick(rng, 1) == 0 ? "" : std::to_string(pick(rng, 4));
      stages[s].push_back(make_task(id, inputs, pick(rng, 3), place));
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

/// What outlives a job: files on the disk and lines of the manifest.
struct Disk {
  std::set<Digest> artifacts;         ///< by key
  std::map<Digest, Digest> manifest;  ///< content by key
  std::set<Digest> unsynced;          ///< lines of the manifest that a kill may lose
  std::set<Digest> let_go;            ///< removed on purpose: nobody was to read them again
};

class Simulation {
 public:
  explicit Simulation(unsigned seed) : rng_(seed), stages_(random_stages(rng_)) { start(); }

  void run() {
    for (int i = 0; !all_done_ || !results_can_be_read(); ++i) {
      ASSERT_LT(i, kMostEvents) << "the bake does not end";
      step();
      if (HasFatalFailure()) return;
    }
    for (const auto& [id, content] : expected_contents(stages_)) {
      const auto result = c_->result(id);
      ASSERT_TRUE(result.has_value()) << id;
      EXPECT_EQ(result->content, content) << id;
      EXPECT_EQ(records_[id], 1) << id << " must be recorded once in a run";
    }
  }

  [[nodiscard]] int kills() const { return kills_; }
  [[nodiscard]] int drains() const { return drains_; }
  [[nodiscard]] int let_go_count() const { return let_go_; }

 private:
  struct Running {
    WorkerId worker;
    Assignment assignment;
  };

  static bool HasFatalFailure() { return testing::Test::HasFatalFailure(); }

  // A job, the first one or the next after a kill: all that it knows comes from the disk.
  void start() {
    Coordinator::Settings settings;
    settings.lease_seconds = 50.0;
    for (const Digest& key : disk_.let_go) {
      if (disk_.manifest.contains(key)) settings.spared.insert(key);
    }
    c_ = std::make_unique<Coordinator>(settings,
                                       KnownContents(disk_.manifest.begin(), disk_.manifest.end()));
    planned_ = 0;
    next_worker_ = 0;
    draining_ = false;
    running_.clear();
    mute_.clear();
    distrusted_.clear();
    asked_for_.clear();
    records_.clear();
    join();
    plan();
  }

  void kill_job() {
    ++kills_;
    // Lines of the manifest may not have reached the disk; their artifacts have.
    for (const Digest& key : disk_.unsynced) {
      if (pick(rng_, 1) == 0) disk_.manifest.erase(key);
    }
    disk_.unsynced.clear();
    start();
  }

  void feed(const Event& event) {
    const std::vector<Command> commands = c_->handle(event);
    ASSERT_NO_THROW(c_->check_invariants());
    bool stage_done = false;
    bool drained = false;
    for (const Command& command : commands) {
      if (const auto* a = std::get_if<Assign>(&command)) {
        assign(*a);
      } else if (const auto* r = std::get_if<Record>(&command)) {
        ++records_[r->done.task];
        if (disk_.manifest.emplace(r->done.key, r->done.content).second) {
          disk_.unsynced.insert(r->done.key);
        }
      } else if (const auto* f = std::get_if<Fail>(&command)) {
        FAIL() << f->message;
      } else {
        drained |= std::holds_alternative<Drained>(command);
        stage_done |= std::holds_alternative<StageDone>(command);
        all_done_ |= std::holds_alternative<AllDone>(command);
      }
    }
    if (stage_done) plan();
    if (!drained) return;
    ASSERT_TRUE(draining_);
    disk_.unsynced.clear();  // the program syncs at an orderly end
    start();
  }

  void assign(const Assign& a) {
    ASSERT_FALSE(draining_) << "a task is started although the bake is to end";
    const std::string& id = a.assignment.task.id;
    const bool asked_for = asked_for_.contains(id);
    ASSERT_TRUE(records_[id] == 0 || asked_for) << id << " is done and is started again";
    ASSERT_TRUE(!disk_.let_go.contains(a.assignment.key) || asked_for)
        << id << " was let go, and is started although nobody reads it";
    running_.push_back({a.worker, a.assignment});
  }

  void plan() {
    std::vector<TaskSpec> tasks;
    for (std::size_t s = 0; s <= planned_; ++s) {
      tasks.insert(tasks.end(), stages_[s].begin(), stages_[s].end());
    }
    const bool last = ++planned_ == stages_.size();
    feed(TasksAdded{tasks, last});
  }

  /// A connection that breaks, or a process that dies: nothing more is heard of that one.
  void lose(WorkerId worker) {
    if (pick(rng_, 1) == 0) {
      std::erase_if(running_, [&](const Running& r) { return r.worker == worker; });
      mute_.insert(worker);
    }
    feed(WorkerLost{worker});
  }

  /// As the program, which reads what it needs in the end, and says so if it cannot.
  bool results_can_be_read() {
    for (const auto& stage : stages_) {
      for (const TaskSpec& task : stage) {
        const auto result = c_->result(task.id);
        const bool there =
            !result || disk_.artifacts.contains(result->key) || disk_.let_go.contains(result->key);
        if (there) continue;
        all_done_ = false;
        asked_for_.insert(task.id);
        feed(ResultUnsound{task.id});
        return false;
      }
    }
    return true;
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
    if (dice < 3 || (dice >= 23 && running_.empty() && !draining_)) {
      join();
    } else if (dice < 4) {
      feed(WorkerJoined{pick(rng_, next_worker_ - 1), 1 + pick(rng_, 2)});
    } else if (dice < 8) {
      lose(pick(rng_, next_worker_));
    } else if (dice < 10) {
      mute_.insert(pick(rng_, next_worker_ - 1));
    } else if (dice < 14 && !finished_.empty()) {
      feed(finished_[pick(rng_, static_cast<int>(finished_.size()) - 1)]);
    } else if (dice < 17) {
      break_input();
    } else if (dice < 20) {
      let_go();
    } else if (dice < 22) {
      kill_job();
    } else if (dice < 23 && !draining_) {
      draining_ = true;
      ++drains_;
      feed(DrainRequested{});
    } else if (!running_.empty()) {
      finish();
    }
  }

  void finish() {
    const Running r = take_any();
    const bool adopted = disk_.artifacts.contains(r.assignment.key);
    for (const TaskInput& input : r.assignment.inputs) {
      if (adopted || disk_.artifacts.contains(input.key)) continue;
      ask_for(r, input);
      return;
    }
    disk_.artifacts.insert(r.assignment.key);
    disk_.let_go.erase(r.assignment.key);
    const TaskDone report = done(r.worker, r.assignment, adopted);
    finished_.push_back(report);
    feed(report);
  }

  /// A file goes bad, and a reader notices.
  void break_input() {
    if (running_.empty()) return;
    const Running r = take_any();
    // Each task distrusts at most once a run, so that no disk looks broken for good.
    if (r.assignment.inputs.empty() || !distrusted_.insert(r.assignment.task.id).second) {
      running_.push_back(r);
      return;
    }
    const int i = pick(rng_, static_cast<int>(r.assignment.inputs.size()) - 1);
    const TaskInput& input = r.assignment.inputs[i];
    disk_.artifacts.erase(input.key);
    ask_for(r, input);
  }

  void ask_for(const Running& r, const TaskInput& input) {
    asked_for_.insert(input.id);
    feed(InputUnsound{r.worker, r.assignment.task.id, input.id});
  }

  /// As with store.keep: needed, once all is planned: what nobody will read goes.
  void let_go() {
    if (planned_ < stages_.size()) return;
    for (const auto& stage : stages_) {
      for (const TaskSpec& task : stage) {
        const auto result = c_->result(task.id);
        if (!result || !disk_.artifacts.contains(result->key) || has_open_reader(task.id)) continue;
        disk_.unsynced.clear();  // as the program: what tells of it comes first
        disk_.artifacts.erase(result->key);
        disk_.let_go.insert(result->key);
        ++let_go_;
        return;
      }
    }
  }

  [[nodiscard]] bool has_open_reader(const std::string& id) const {
    for (const auto& stage : stages_) {
      for (const TaskSpec& task : stage) {
        if (std::ranges::find(task.inputs, id) != task.inputs.end() && !c_->result(task.id)) {
          return true;
        }
      }
    }
    return false;
  }

  Rng rng_;
  std::vector<std::vector<TaskSpec>> stages_;
  Disk disk_;
  std::unique_ptr<Coordinator> c_;
  std::size_t planned_ = 0;
  WorkerId next_worker_ = 0;
  double now_ = 0.0;
  bool all_done_ = false;
  bool draining_ = false;
  int kills_ = 0;
  int drains_ = 0;
  int let_go_ = 0;
  std::vector<Running> running_;
  std::vector<TaskDone> finished_;  ///< of all runs: any of them may come late
  std::set<WorkerId> mute_;
  std::set<std::string> distrusted_;
  std::set<std::string> asked_for_;  ///< tasks whose artifact a reader missed
  std::map<std::string, int> records_;
};

TEST(CoordinatorRandom, EveryDisturbedBakeGivesTheUndisturbedResult) {
  int kills = 0;
  int drains = 0;
  int let_go = 0;
  for (unsigned seed = 0; seed < kGraphs && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Simulation simulation(seed);
    simulation.run();
    kills += simulation.kills();
    drains += simulation.drains();
    let_go += simulation.let_go_count();
  }
  EXPECT_GT(kills, kGraphs / 4);
  EXPECT_GT(drains, kGraphs / 8);
  EXPECT_GT(let_go, kGraphs / 8);
}

}  // namespace
}  // namespace prt
