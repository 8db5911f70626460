// The loops of a running bake: they move messages, start threads and tell the time; every decision
// is the coordinator's or the worker's.
#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "jobs/coordinator.h"
#include "jobs/link.h"
#include "jobs/slots.h"

namespace prt {

/// What the coordinating rank's loop asks of the bake.
class BakeHost {
 public:
  virtual ~BakeHost() = default;
  /// A task is done for the first time in this run: write it down.
  virtual void record(const Record& record) = 0;
  /// All planned tasks are done: plan on. Answers TasksAdded, or ResultUnsound.
  virtual Event plan_on(const Coordinator& coordinator) = 0;
  /// All is done: write the results. Answers ResultUnsound to have an artifact made again first.
  virtual std::optional<Event> finish(const Coordinator& coordinator) = 0;
  /// Called between any two events, at least every few milliseconds.
  virtual void tick(const Coordinator& coordinator, double now) = 0;
};

/// How a loop ended. The other ranks have not been told yet: dismiss_all does that.
struct LoopEnd {
  ExitCode code = ExitCode::kDone;
  std::string message;  ///< of a failure; empty otherwise
};

struct ServiceSettings {
  /// Coordinator and workers tell each other at least that often that they are there.
  double heartbeat_seconds = 5.0;
  /// A worker that hears nothing from its coordinator for longer goes home. Long: the coordinator
  /// is silent while it plans and writes results.
  double patience_seconds = 600.0;
  /// Set by a signal handler: leave everything resumable and end with ExitCode::kInterrupted.
  const std::atomic<bool>* stop = nullptr;
  /// Set by a signal handler: the same, once running tasks are done.
  const std::atomic<bool>* drain = nullptr;
  double grace_seconds = 30.0;  ///< how long draining may take
};

/// Rank 0: coordinates and works too. Returns when all is done, failed or stopped. Exceptions of
/// the host pass through.
LoopEnd run_coordinator(Coordinator& coordinator, BakeHost& host, Link& link, Slots& slots,
                        const ServiceSettings& settings);

/// Sends every other rank home, joined or not. Call once, after run_coordinator and whatever
/// follows it.
void dismiss_all(Link& link, ExitCode code);

/// Any other rank: works until dismissed or stopped.
ExitCode run_worker(Link& link, Slots& slots, const ServiceSettings& settings);

}  // namespace prt
