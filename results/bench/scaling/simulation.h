// A bake that takes no time: the real coordinator hands out tasks to simulated ranks.
#pragma once

#include <algorithm>

#include "scaling/bake_graph.h"
#include "scaling/measured_bake.h"

namespace prt::scaling {

/// What is not measured on the way. The defaults are assumptions about a cluster; a rank is a core.
struct Machine {
  int ranks = 1;
  double latency = 20e-6;           ///< of a message, s
  double poll = 1e-3;               ///< both loops look for messages that often, s (service.cpp)
  double rank_bandwidth = 0.5e9;    ///< bytes/s of one rank
  double total_bandwidth = 100e9;   ///< bytes/s of all
  double open_seconds = 0.5e-3;     ///< per file read
  double commit_seconds = 5e-3;     ///< per artifact: create, sync, rename
  double cache_bytes = 1 << 30;     ///< of inputs that a rank keeps (bake_runner.cpp)
  double launch_seconds = 0.5;      ///< of the job ...
  double launch_per_rank = 1e-3;    ///< ... and more with every rank
  double scene_seconds = 0.1;       ///< every rank loads the scene
  double first_task_seconds = 0.1;  ///< and makes a ray caster and a neighbour search
  double decode_per_byte = 3e-9;    ///< CPU seconds per byte read, as prt_inspect --verify takes
  Law assembly = {};       ///< seconds of start-up, planning and a package of so many bytes
  double heartbeat = 5.0;  ///< every rank says that it is there, s
  /// The coordinator's own work is measured while it runs, and takes that time in the simulation.
  bool charge_coordinator = true;
};
/// Nothing costs anything but the tasks.
Machine ideal_machine(int ranks);

struct Outcome {
  double seconds = 0.0;  ///< of the bake
  double busy = 0.0;     ///< seconds that ranks computed, all together
  double disk = 0.0;     ///< seconds that ranks read or wrote, all together
  double read_bytes = 0.0;
  double coordinator = 0.0;  ///< seconds that the coordinator worked, planning aside
  double planning = 0.0;     ///< seconds
  std::size_t completions = 0;
};
Outcome simulate(const BakeGraph& graph, const Machine& machine);

/// CPU seconds of this thread.
double thread_seconds();
/// What asking for them twice takes by itself: a microsecond on a virtual machine.
double clock_cost();

/// CPU seconds that `work` takes.
template <typename Work>
double timed(Work&& work) {
  const double began = thread_seconds();
  work();
  return std::max(0.0, thread_seconds() - began - clock_cost());
}

}  // namespace prt::scaling
