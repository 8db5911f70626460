// The wire format: JSON text, one object per message. Text because it is read in traces and tests,
// and because a message carries at most a few hundred hashes.
#pragma once

#include <string>
#include <variant>

#include "jobs/protocol.h"

namespace prt {

/// What a coordinator sends to a worker.
struct Dismissed {
  ExitCode code = ExitCode::kDone;
};
/// The coordinator is alive.
struct StillHere {};
using Order = std::variant<Assignment, Dismissed, StillHere>;

std::string encode_order(const Order& order);
/// Throws UnsoundData for anything that is not a message of ours.
Order decode_order(const std::string& text);

/// Events that a worker sends to its coordinator: WorkerJoined, TaskDone, TaskFailed, InputUnsound,
/// Heartbeat, and StopRequested or DrainRequested (a signal told the worker so).
std::string encode_report(const Event& event);
Event decode_report(const std::string& text);

}  // namespace prt
