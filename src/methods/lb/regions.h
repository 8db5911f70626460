// Regions and windows as the planner sees them: what there is once per region, and who works where.
#pragma once

#include <string>
#include <vector>

#include "domains/windows.h"
#include "jobs/task.h"
#include "methods/options.h"
#include "store/artifact.h"

namespace prt::lb {

/// Most clusters of a window, but where regions were asked to be large. The dense system of one has
/// some 40 unknowns per cluster in the first round of snapshots and takes 1 GB.
inline constexpr std::size_t kWindowClusters = 192;

/// Up to so many clusters, whose system takes 2 GB, a scene is solved for as a whole ...
inline constexpr std::size_t kWholeClusters = 256;
/// ... and above in regions of so many.
inline constexpr std::size_t kRegionClusters = 64;

/// Most clusters of a region in a scene of so many. Photons need no system: one region.
std::size_t most_region_clusters(const OptionValues& options, std::size_t clusters);

/// Most clusters of the windows of such regions: room for as many again on either side.
std::size_t most_window_clusters(std::size_t most_region_clusters);

/// TaskSpec::place of what casts or reads each cluster's rays. Regions of at most `most` clusters
/// are known from the samples alone (make_regions), so whoever casts a region's rays has its
/// neighbourhood in memory when its window is worked on. `samples`: see store/samples_io.h.
std::vector<std::string> cluster_places(const Artifact& samples, std::size_t most);

/// Names "stage/0007" of some clusters' tasks.
std::vector<std::string> numbered_all(const std::string& stage,
                                      const std::vector<std::uint32_t>& clusters);

class Regions {
 public:
  Regions() = default;
  /// `regions` hold every cluster once. One region: the scene is solved for as a whole.
  Regions(std::vector<Region> regions, std::size_t clusters);
  /// One region of all clusters.
  static Regions whole(std::size_t clusters);

  [[nodiscard]] std::size_t count() const { return regions_.size(); }
  [[nodiscard]] const Region& operator[](std::size_t r) const { return regions_[r]; }
  /// The region that a cluster is in.
  [[nodiscard]] std::size_t of(std::size_t cluster) const { return region_of_[cluster]; }
  [[nodiscard]] const std::vector<std::uint32_t>& window_of(std::size_t cluster) const {
    return regions_[of(cluster)].window;
  }
  /// Whether there are several, so that tasks work in windows.
  [[nodiscard]] bool several() const { return regions_.size() > 1; }
  /// Name of what there is once per region.
  [[nodiscard]] std::string name(const std::string& stage, std::size_t r) const;
  /// Name of the light functions that tasks of a region read.
  [[nodiscard]] std::string light_functions(std::size_t r) const;
  /// Makes a task work in a region's window (scene_part.h), on a rank that works there: the last
  /// thing to do to its inputs.
  void place(TaskSpec& spec, std::size_t r) const;
  /// TaskSpec::place of a region's tasks.
  [[nodiscard]] static std::string place(std::size_t r);
  /// Regions whose example lights are known to reach each cluster: those in whose windows it is.
  [[nodiscard]] std::vector<std::vector<std::size_t>> lit_by() const;
  /// Example lights of each region, so that a cluster has about `wanted` of the regions that light
  /// it, and a window no fewer than `least`.
  [[nodiscard]] std::size_t lights(std::size_t wanted, std::size_t least) const;
  /// Regions that a window has clusters of, ascending.
  [[nodiscard]] std::vector<std::size_t> in_window(std::size_t r) const;

 private:
  std::vector<Region> regions_;
  std::vector<std::size_t> region_of_;
};

}  // namespace prt::lb
