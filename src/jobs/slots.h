// Threads of one rank: each slot runs one task at a time. The thread that owns a Slots object never
// runs a task itself; it alone talks to other ranks.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "jobs/worker.h"

namespace prt {

/// Checks or makes one artifact. Called on several threads at once. Throws UserError, Interrupted,
/// InputDistrusted, or anything else; the slot turns it into an Outcome.
class TaskRunner {
 public:
  virtual ~TaskRunner() = default;
  struct Made {
    Digest content;
    bool adopted = false;
    std::uint64_t bytes = 0;
    nlohmann::json figures = nlohmann::json::object();  ///< see TaskDone
  };
  virtual Made run(const Assignment& assignment, const std::atomic<bool>& stop) = 0;
};

/// An input's artifact is missing or bad: its producer has to run again.
class InputDistrusted : public std::runtime_error {
 public:
  InputDistrusted(std::string task, const std::string& why)
      : std::runtime_error(why), input(std::move(task)) {}
  std::string input;
};

/// The boundary of a task: whatever it throws becomes an Outcome.
Outcome run_guarded(TaskRunner& runner, const Assignment& assignment, int slot,
                    const std::atomic<bool>& stop);

class Slots {
 public:
  Slots(int count, TaskRunner& runner);
  /// Asks running tasks to stop and waits for them.
  ~Slots();
  Slots(const Slots&) = delete;
  Slots& operator=(const Slots&) = delete;

  [[nodiscard]] int count() const { return static_cast<int>(threads_.size()); }
  void start(int slot, Assignment assignment);
  /// What ended since the last call.
  std::vector<SlotFinished> take_finished();
  /// Returns when a slot has ended, or after `most`.
  void wait(std::chrono::microseconds most);
  /// Running tasks are asked to stop; none is started any more.
  void request_stop();
  /// True once no thread runs a task.
  [[nodiscard]] bool idle() const;

 private:
  void work(int slot);

  TaskRunner& runner_;
  mutable std::mutex mutex_;
  std::condition_variable finished_signal_;
  std::condition_variable work_signal_;
  std::vector<std::optional<Assignment>> orders_;
  std::vector<SlotFinished> finished_;
  int busy_ = 0;
  std::atomic<bool> stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace prt
