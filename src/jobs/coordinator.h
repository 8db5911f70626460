// Who does what next: a pure state machine without clock, files, threads or messages. The same code
// runs a bake, random-graph tests and simulations. See README.md for the protocol.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "jobs/protocol.h"

namespace prt {

/// Content hashes by KEY that an earlier run recorded.
using KnownContents = std::map<Digest, Digest>;

/// How far one stage (all tasks of a kind) is.
struct StageProgress {
  std::size_t total = 0;
  std::size_t done = 0;
  std::size_t adopted = 0;  ///< of those done: found on disk
  double cost_total = 0.0;  ///< as planned, seconds
  double cost_done = 0.0;
  double cost_adopted = 0.0;  ///< of cost_done
};

/// Workers that ever joined, by what they are now.
struct RankCounts {
  int busy = 0;  ///< run a task
  int idle = 0;
  int lost = 0;
};

class Coordinator {
 public:
  struct Settings {
    SceneHashes scene;
    double lease_seconds = 0.0;  ///< a worker silent for longer is taken for lost; 0: never
    /// KEYs whose artifact was let go on purpose once all that read it were done (store.keep:
    /// needed). Their tasks count as done; one that is read after all is made again.
    std::set<Digest> spared = {};
  };

  Coordinator(Settings settings, KnownContents known);
  Coordinator(const Coordinator&) = delete;
  Coordinator& operator=(const Coordinator&) = delete;

  [[nodiscard]] std::vector<Command> handle(const Event& event);

  /// Progress by stage, in order of first appearance.
  [[nodiscard]] std::vector<std::pair<std::string, StageProgress>> progress() const;
  [[nodiscard]] std::size_t undone() const { return undone_; }
  [[nodiscard]] RankCounts ranks() const;
  /// Workers that are taken for lost.
  [[nodiscard]] std::vector<WorkerId> lost() const;
  /// Where the artifact of a finished task lies; empty while the task is unknown or not done.
  [[nodiscard]] std::optional<TaskInput> result(const std::string& task) const;

  /// Throws std::logic_error naming the first invariant that does not hold (none is claimed after a
  /// Fail). For tests.
  void check_invariants() const;

 private:
  enum class State { kWaiting, kReady, kAssigned, kDone };
  struct Task {
    TaskSpec spec;
    State state = State::kWaiting;
    std::vector<std::size_t> inputs;
    std::vector<std::size_t> dependents;
    std::size_t missing = 0;  ///< inputs that are not done
    bool recorded = false;
    bool adopted = false;
    std::optional<Digest> key;
    Digest content;
    WorkerId worker = -1;
    std::size_t place = 0;  ///< in places_
    double chain = 0.0;     ///< cost of the longest chain that begins with it, as of its plan
  };
  /// Longest chain first, then by id.
  struct ReadyOrder {
    const std::vector<Task>* tasks;
    bool operator()(std::size_t a, std::size_t b) const;
  };
  struct Place {
    WorkerId holder = -1;  ///< -1: nobody
    std::vector<std::size_t> tasks;
  };
  using ReadyTasks = std::set<std::size_t, ReadyOrder>;
  struct WorkerState {
    explicit WorkerState(const ReadyOrder& order) : ready(order) {}
    int slots = 0;
    bool present = false;
    std::set<std::size_t> tasks;
    double heard = 0.0;
    std::vector<std::size_t> places;  ///< that it holds: it ran their first task
    ReadyTasks ready;                 ///< ready tasks of those
  };

  void on(const WorkerJoined& event);
  void on(const TasksAdded& event);
  void on(const TaskDone& event);
  void on(const TaskFailed& event);
  void on(const InputUnsound& event);
  void on(const ResultUnsound& event);
  void on(const Heartbeat& event);
  void on(const WorkerLost& event);
  void on(const Tick& event);
  void on(const StopRequested& event);
  void on(const DrainRequested& event);

  void hear(WorkerId worker);
  bool add_task(const TaskSpec& spec);
  bool link_inputs(std::size_t task);
  [[nodiscard]] std::vector<std::size_t> in_order(std::size_t first_new) const;
  void measure_chains(const std::vector<std::size_t>& order);
  void release(std::size_t task);
  void detach(std::size_t task);
  void make_ready(std::size_t task);
  void finish(std::size_t task, const TaskDone& event);
  void undo(std::size_t task);
  void distrust(std::size_t reader, std::size_t task);
  void lose(WorkerState& worker);
  void offer(WorkerId id, WorkerState& worker);
  void withdraw(WorkerId id, WorkerState& worker);
  void give_up_places(WorkerState& worker);
  void take_place(std::size_t place, WorkerId id, WorkerState& worker);
  [[nodiscard]] ReadyTasks& list_of(std::size_t task);
  void add_ready(std::size_t task);
  void remove_ready(std::size_t task);
  [[nodiscard]] const ReadyTasks& best_for(WorkerId worker) const;
  void hand_out();
  [[nodiscard]] bool spare(std::size_t task);
  void assign(std::size_t task, WorkerId worker);
  void announce();
  void fail(std::string message, bool user_error = false);
  [[nodiscard]] std::size_t find(const std::string& id) const;
  [[nodiscard]] Digest key_of(const Task& task) const;
  void check_task(std::size_t index) const;
  void check_workers() const;

  Settings settings_;
  KnownContents contents_;
  std::vector<Task> tasks_;
  std::unordered_map<std::string, std::size_t> index_;
  std::vector<std::string> stages_;
  std::map<std::string, StageProgress> stage_progress_;
  std::map<WorkerId, WorkerState> workers_;
  std::set<std::pair<int, WorkerId>> free_;  ///< (-free slots, worker): the freest first
  std::set<WorkerId> served_;                ///< of those: who holds the place of a ready task
  ReadyTasks ready_;
  ReadyTasks unplaced_;        ///< of those: nobody holds their place
  std::vector<Place> places_;  ///< the first is that of tasks without one: nobody ever holds it
  std::unordered_map<std::string, std::size_t> place_index_;
  std::size_t undone_ = 0;
  /// How often a reader could not trust a task's artifact; the planner counts as the task itself.
  std::map<std::pair<std::size_t, std::size_t>, int> distrust_;
  double now_ = 0.0;
  bool clock_started_ = false;
  bool last_plan_ = false;
  bool announced_ = true;
  bool stopped_ = false;
  bool draining_ = false;
  bool failed_ = false;
  std::vector<Command> commands_;
};

}  // namespace prt
