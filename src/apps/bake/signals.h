// SIGTERM, SIGINT and SIGUSR1 mean: stop, leave everything resumable, be gone within a second.
#pragma once

#include <atomic>
#include <chrono>

#include "base/error.h"

namespace prt {

/// From now on those signals set the flag, and end the process with ExitCode::kInterrupted if it is
/// still there a little later (a result is only ever complete or absent, so any moment is safe). A
/// second signal ends it at once.
void catch_stop_signals();
const std::atomic<bool>& stop_flag();

/// Ends the process with `code` unless it ends by itself within `most`: for tasks that do not
/// listen and ranks that do not answer.
void end_within(std::chrono::milliseconds most, ExitCode code);

}  // namespace prt
