// SIGTERM and SIGINT mean: stop, leave everything resumable, be gone within a second. SIGUSR1, a
// scheduler's warning, means the same once running tasks are done.
#pragma once

#include <atomic>
#include <chrono>

#include "base/error.h"

namespace prt {

/// From now on SIGTERM and SIGINT set the stop flag, and end the process with
/// ExitCode::kInterrupted if it is still there a little later (a result is only ever complete or
/// absent, so any moment is safe); a second one ends it at once. SIGUSR1 sets the drain flag.
void catch_stop_signals();
const std::atomic<bool>& stop_flag();
const std::atomic<bool>& drain_flag();

/// Ends the process with `code` unless it ends by itself within `most`: for tasks that do not
/// listen and ranks that do not answer.
void end_within(std::chrono::milliseconds most, ExitCode code);

}  // namespace prt
