// The bakes whose scaling is predicted.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scaling/measured_bake.h"
#include "scaling/rank_set_up.h"
#include "scaling/simulation.h"

namespace prt::scaling {

/// A finished bake of one rank and one thread, and what a rank does before its first task.
struct BakeFacts {
  MeasuredBake bake;
  RankSetUp set_up;
};
BakeFacts read_facts(const std::string& folder);

/// Where a what-if differs from the plan and the costs of today.
struct Change {
  std::string name;
  std::map<std::string, std::size_t> parts = {};  ///< GraphSettings::parts
  bool even_clusters = false;                     ///< all of the mean size
  double search_share = 1.0;                      ///< of today's neighbour search, per rank
  bool search_whole = false;     ///< made for all of the scene by every rank, as it once was
  bool keeps_rays = false;       ///< whoever reads rays has them in memory
  bool forgets = false;          ///< a rank keeps nothing from task to task
  double bandwidth_share = 1.0;  ///< of the file system's
  double poll_share = 1.0;
  double scene_share = 1.0;    ///< of loading the scene and making the ray caster, per rank
  double package_share = 1.0;  ///< of writing the package
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
/// included: what is then simulated can be held against what the bake took. Throws where the bake
/// has other tasks than the graph.
Workload replayed_workload(const BakeFacts& facts);

/// How costs grow: from bakes of one scene at several sizes, the middle one at the paper's, and
/// from one in regions.
struct CityFacts {
  std::vector<BakeFacts> bakes;
  BakeFacts regions;
};
/// Clusters of a city on a square grid, and how it is cut up.
struct CityPlan {
  std::size_t clusters = 0;
  std::vector<Region> regions;   ///< empty: solved for as a whole
  std::vector<Vec3f> centres;    ///< of the clusters
  double windows_seconds = 0.0;  ///< CPU, of finding the regions' windows
};
/// `window`: most clusters of a region's window, and in a big city the number that it has.
CityPlan plan_city(std::size_t clusters, std::size_t window);
/// A bake of clusters of 1000 samples.
Workload city_workload(const CityFacts& facts, const CityPlan& plan, const Change& change = {});

/// Seconds by kind.
std::map<std::string, double> seconds_by_kind(const BakeGraph& graph);

}  // namespace prt::scaling
