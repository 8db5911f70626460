// What the coordinator hears and what it answers, as values. The protocol's rules are in README.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/hash.h"
#include "jobs/task.h"

namespace prt {

using WorkerId = int;  ///< the worker's rank

/// What a task took. Only for reports: no result and no decision depends on it.
struct TaskCost {
  double began = 0.0;  ///< wall clock, seconds since 1970
  double seconds = 0.0;
  double cpu_seconds = 0.0;
  std::uint64_t bytes = 0;  ///< of the artifact's file
  int slot = 0;             ///< which of the worker's threads
};

// ---- events ------------------------------------------------------------------------------------

/// A worker is there and runs up to `slots` tasks side by side.
struct WorkerJoined {
  WorkerId worker = 0;
  int slots = 1;
};
/// More tasks, or known ones repeated unchanged. `last`: no plan will bring more.
struct TasksAdded {
  std::vector<TaskSpec> tasks;
  bool last = false;
};
/// An artifact lies on disk, whole and verified. `adopted`: it was there already.
struct TaskDone {
  WorkerId worker = 0;
  std::string task;
  Digest key;
  Digest content;
  bool adopted = false;
  TaskCost cost;
  /// Numbers among the artifact's attributes (measured errors, ranks), for the report; empty if it
  /// was adopted.
  nlohmann::json figures = nlohmann::json::object();
};
struct TaskFailed {
  WorkerId worker = 0;
  std::string task;
  std::string message;
  bool user_error = false;
};
/// The artifact of `input` could not be trusted when `task` wanted to read it.
struct InputUnsound {
  WorkerId worker = 0;
  std::string task;
  std::string input;
};
/// The planner itself could not trust the artifact of a finished task.
struct ResultUnsound {
  std::string task;
};
struct Heartbeat {
  WorkerId worker = 0;
};
struct WorkerLost {
  WorkerId worker = 0;
};
/// Time passes; any clock that does not run backwards, seconds.
struct Tick {
  double now = 0.0;
};
/// Hand out no more and send everybody home with this exit code.
struct StopRequested {
  ExitCode code = ExitCode::kInterrupted;
};

/// Hand out no more, but let running tasks end: a scheduler's warning.
struct DrainRequested {};

using Event =
    std::variant<WorkerJoined, TasksAdded, TaskDone, TaskFailed, InputUnsound, ResultUnsound,
                 Heartbeat, WorkerLost, Tick, StopRequested, DrainRequested>;

// ---- commands ----------------------------------------------------------------------------------

/// Where an input's artifact lies and what must be in it.
struct TaskInput {
  std::string id;
  std::string stage;
  Digest key;
  Digest content;
};
/// One task as its worker gets it: check artifact KEY, or make it.
struct Assignment {
  TaskSpec task;
  Digest key;
  std::optional<Digest> expected;  ///< content hash, if an earlier run or worker reported one
  std::vector<TaskInput> inputs;   ///< in the order of task.inputs
};
struct Assign {
  WorkerId worker = 0;
  Assignment assignment;
};
/// A task is done for the first time in this run. `known`: this very result was known beforehand.
struct Record {
  TaskDone done;
  std::string stage;
  bool known = false;
};
/// All tasks known so far are done: plan again.
struct StageDone {};
/// All tasks are done and no more will come.
struct AllDone {};
/// The bake cannot go on; what is done stays done.
struct Fail {
  std::string message;
  bool user_error = false;
};
struct Dismiss {
  WorkerId worker = 0;
  ExitCode code = ExitCode::kDone;
};
/// After DrainRequested: no task runs any more.
struct Drained {};

using Command = std::variant<Assign, Record, StageDone, AllDone, Fail, Dismiss, Drained>;

}  // namespace prt
