// One rank as a worker: a pure state machine between the coordinator's orders and the rank's
// threads.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "jobs/messages.h"
#include "jobs/protocol.h"

namespace prt {

/// What a thread made of its assignment.
struct Outcome {
  enum class Kind { kDone, kFailed, kInputUnsound, kDropped } kind = Kind::kDone;
  Digest content;           ///< kDone
  bool adopted = false;     ///< kDone
  std::string message;      ///< kFailed
  bool user_error = false;  ///< kFailed
  std::string input;        ///< kInputUnsound: id of the task whose artifact is bad
  TaskCost cost;
  nlohmann::json figures = nlohmann::json::object();  ///< kDone, see TaskDone
};

/// Slot `slot` ended its assignment.
struct SlotFinished {
  int slot = 0;
  Outcome outcome;
};

/// Run this on that slot's thread.
struct Start {
  int slot = 0;
  Assignment assignment;
};
/// Tell the coordinator.
struct Report {
  Event event;
};
/// End the loop with this code; what still runs is dropped.
struct Leave {
  ExitCode code = ExitCode::kDone;
};

using WorkerEvent = std::variant<Order, SlotFinished, Tick>;
using WorkerAction = std::variant<Start, Report, Leave>;

class Worker {
 public:
  /// `heartbeat_seconds`: it tells at least that often that it is alive; 0: never.
  /// `patience_seconds`: it leaves, interrupted, when it has heard nothing from the coordinator for
  /// longer; 0: it waits for ever.
  Worker(WorkerId id, int slots, double heartbeat_seconds = 0.0, double patience_seconds = 0.0);

  /// First thing to report.
  [[nodiscard]] WorkerJoined join() const;
  /// Whether an order could be started at once.
  [[nodiscard]] bool has_free_slot() const { return !idle_.empty(); }
  [[nodiscard]] std::vector<WorkerAction> handle(const WorkerEvent& event);

 private:
  void on(const Order& order, std::vector<WorkerAction>& actions);
  void on(const SlotFinished& finished, std::vector<WorkerAction>& actions);
  void on(const Tick& tick, std::vector<WorkerAction>& actions);
  void start_waiting(std::vector<WorkerAction>& actions);
  [[nodiscard]] bool has(const std::string& task) const;

  WorkerId id_;
  int slots_;
  double heartbeat_seconds_;
  double patience_seconds_;
  double told_ = 0.0;
  double now_ = 0.0;
  double heard_ = 0.0;
  bool leaving_ = false;
  std::set<int> idle_;
  std::map<int, Assignment> running_;  ///< by slot
  std::deque<Assignment> waiting_;     ///< more than slots: only after it was taken for lost
};

}  // namespace prt
