// The task graph of method lb, from numbers: what plan.cpp, sampling.cpp and rays.cpp would plan.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "jobs/task.h"
#include "scaling/measured_bake.h"

namespace prt::scaling {

/// What a task takes beside waiting.
struct Load {
  double seconds = 0.0;  ///< of computing
  double bytes = 0.0;    ///< of its artifact
  /// Of computing on each rank whose tasks cast rays and read its artifact: the neighbour search.
  double use_seconds = 0.0;
  std::size_t use_group = 0;  ///< artifacts of one group share that work
  double files = 1.0;         ///< that its artifact stands for, see GraphSettings::gates
  double stands_for = 0.0;    ///< inputs that its spec leaves out
  bool is_written = true;
  bool is_kept = false;  ///< whoever reads it has it already
};

/// Tasks in an order in which each comes after its inputs.
struct BakeGraph {
  std::vector<TaskSpec> tasks;
  std::vector<Load> loads;
  std::vector<std::vector<std::size_t>> inputs;
  /// Tasks known after each call of the planner; the last entry is tasks.size().
  std::vector<std::size_t> plans;
  double package_bytes = 0.0;
  std::unordered_map<std::string, std::size_t> index;

  void add(TaskSpec spec, const Load& load);
  void end_plan() { plans.push_back(tasks.size()); }
  [[nodiscard]] double work() const;
};

/// Seconds along the longest chain, by kind; every plan waits for all tasks of the one before.
std::map<std::string, double> longest_chain(const BakeGraph& graph);

/// Seconds and bytes of a task of `kind` on `samples` samples whose result refers to `reach`
/// clusters.
using Cost = std::function<Load(const std::string& kind, double samples, double reach)>;

struct GraphSettings {
  std::vector<double> sizes;  ///< samples of each cluster
  /// The graph of today: 1. More: what concerns the whole scene today is done tile by tile, and a
  /// cluster exchanges light with its own tile and the two beside it alone.
  std::size_t tiles = 1;
  /// Input lists that name every cluster's artifact are replaced by a task of no cost, a gate. The
  /// coordinator's work for them is charged apart (Load::stands_for).
  bool gates = false;
  /// Sweeps of the reduced system over all tiles, and tasks per tile and sweep.
  std::size_t sweeps = 1;
  std::size_t solve_parts = 1;  ///< per channel
  std::size_t channels = 3;
  double candidate_tasks = 11.0;
  double cell_tasks = 10.0;
};

BakeGraph make_lb_graph(const GraphSettings& settings, const Cost& cost);

}  // namespace prt::scaling
