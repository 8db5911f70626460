// The bakes whose scaling is predicted.
#pragma once

#include <string>
#include <vector>

#include "scaling/rank_set_up.h"
#include "scaling/simulation.h"

namespace prt::scaling {

/// A finished bake of one rank and one thread, and what a rank does before its first task.
struct BakeFacts {
  MeasuredBake bake;
  RankSetUp set_up;
};
BakeFacts read_facts(const std::string& folder);

/// Where a what-if differs from the graph and the costs of today.
struct Change {
  std::string name;
  bool even_clusters = false;    ///< all of the mean size
  double serial_parts = 1.0;     ///< tasks that points, solve and evaluate are each split into
  double search_share = 1.0;     ///< of today's neighbour search, per rank
  bool keeps_inputs = false;     ///< whoever reads anything has it in memory: perfect placement
  bool keeps_rays = false;       ///< whoever reads rays has them in memory
  double bandwidth_share = 1.0;  ///< of the file system's
  double poll_share = 1.0;
  double scene_share = 1.0;     ///< of loading the scene and making the ray caster, per rank
  bool ignores_places = false;  ///< any rank gets any task
};

struct Workload {
  std::string name;
  BakeGraph graph;
  Machine machine;  ///< but for the ranks
};

/// A measured bake as it is.
Workload measured_workload(const std::string& name, const BakeFacts& facts,
                           const Change& change = {});

/// The tasks of a bake of one or more ranks with the wall time that each took, reading and writing
/// included: what is then simulated can be held against what the bake took.
Workload replayed_workload(const MeasuredBake& bake);

/// How costs grow: from bakes of one scene at several sizes, the middle one at the paper's.
struct CityFacts {
  std::vector<BakeFacts> bakes;
  double edge_seconds = 0.0;  ///< of the coordinator per input
};
/// `clusters` clusters of 1000 samples, by the rules of today.
Workload city_today(const CityFacts& facts, std::size_t clusters);
/// The same in tiles of as many clusters as the gallery has, each of which exchanges light with two
/// neighbours; no stage concerns the whole scene.
Workload city_in_tiles(const CityFacts& facts, std::size_t clusters, const Change& change = {});

/// Seconds per task or stage of today's rules at that many clusters, by kind.
std::map<std::string, double> seconds_by_kind(const BakeGraph& graph);

/// Coordinator seconds per input, from a graph of `clusters` clusters whose inputs are all named.
double measure_edge_seconds(const BakeFacts& facts, std::size_t clusters);

}  // namespace prt::scaling
