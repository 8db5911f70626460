// The task graph of a bake that never runs: what method lb's planner and the evaluation plan for a
// scene of which no more is known than its clusters and regions.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "domains/windows.h"
#include "jobs/task.h"
#include "methods/options.h"

namespace prt::scaling {

/// What a task takes beside waiting.
struct Load {
  double seconds = 0.0;  ///< of computing
  double bytes = 0.0;    ///< of its artifact
  /// Of computing on each rank whose tasks cast rays and read its artifact: the neighbour search
  /// ...
  double use_seconds = 0.0;
  /// ... of which this task, when it casts rays, wants a part of that number and share.
  std::size_t search_part = 0;
  double search_share = 1.0;
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

/// What a task is about.
struct TaskSize {
  double samples = 0.0;  ///< of its cluster, region or window, or of the scene
  double reach = 0.0;    ///< clusters that its result may refer to: of its window, or of the scene
};
/// The cluster that a task is about, if it is about one.
std::optional<std::size_t> cluster_of(const TaskSpec& task);
using Cost = std::function<Load(const TaskSpec& task, const TaskSize& size)>;

/// The scene and its bake as the planner comes to know them.
struct GraphSettings {
  OptionValues options;
  std::vector<double> sizes;  ///< samples of each cluster
  double area = 1.0;          ///< of all triangles, m²
  double spacing = 0.1;       ///< of the samples, m
  bool grey = false;
  std::vector<Region> regions;  ///< needed if the options want regions ...
  std::vector<Vec3f> centres;   ///< ... and so are the clusters' centres, of which they are made
  /// What-if: so many tasks in the place of each of a kind, which share out inputs and work.
  std::map<std::string, std::size_t> parts;
};

/// One round of snapshots. Throws std::logic_error where the planner asks for what is not known.
BakeGraph make_lb_graph(const GraphSettings& settings, const Cost& cost);

/// The region that each of `clusters` clusters is in; all in region 0 where there are none.
std::vector<std::size_t> regions_of_clusters(const std::vector<Region>& regions,
                                             std::size_t clusters);

}  // namespace prt::scaling
