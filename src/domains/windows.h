// Splits a big scene into regions of clusters whose light is solved for apart, each within a window
// of the clusters that it exchanges light with.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/types.h"

namespace prt {

/// One bounce between clusters, all samples of a cluster taken together: receiver cluster r lists
/// in [begin[r], begin[r+1]) which share of its hemispheres, cosine-weighted, in the mean over its
/// area, each sender cluster fills.
struct ClusterExchange {
  std::vector<std::uint32_t> begin;    ///< clusters + 1
  std::vector<std::uint32_t> senders;  ///< clusters, ascending within a receiver
  std::vector<float> shares;
};

/// Clusters that are solved for together, and the part of the scene that they are given.
struct Region {
  std::vector<std::uint32_t> clusters;  ///< ascending; every cluster is in one region
  std::vector<std::uint32_t> window;    ///< ascending, all of `clusters` among them
  /// Share of the region's indirect light that passes through clusters outside its window where
  /// direct light is the same everywhere: an upper bound of what is lost if all of the window's own
  /// exchange is kept. A lamp among clusters that are left out loses all that it sends here, one in
  /// the region next to nothing.
  double left_out = 0.0;
};

/// Mean position of each cluster's samples. `positions`: of all samples; `cluster_begin`: clusters
/// + 1, see SampleSet.
std::vector<Vec3f> cluster_centres(std::span<const Vec3f> positions,
                                   std::span<const std::uint32_t> cluster_begin);

/// The fewest regions of at most `most` clusters, of about equal size: split again and again along
/// the longest side of their centres' box.
std::vector<std::vector<std::uint32_t>> make_regions(std::span<const Vec3f> centres,
                                                     std::size_t most);

/// What a window has to hold.
struct WindowLimits {
  double tolerance = 0.01;          ///< of Region::left_out
  std::size_t most_clusters = 192;  ///< of a window that is larger than its region, even so
};

/// Where light makes a scene so many times as bright as direct light alone, it is as good as never
/// lost.
inline constexpr double kMostGain = 1e4;

/// Irradiance of every cluster where direct light is 1 everywhere, all bounces summed up:
/// E = 1 + T E. Ends at kMostGain.
VectorD uniform_irradiance(const ClusterExchange& exchange, const VectorD& albedo);

/// The smallest windows that leave out at most the tolerance: clusters by how much of the region's
/// light passes through them, all bounces counted (the adjoint Neumann series of
/// T = shares · albedo). `albedo`, `areas` (m²): of each
/// cluster; `lit`: uniform_irradiance.
std::vector<Region> find_windows(const std::vector<std::vector<std::uint32_t>>& regions,
                                 const ClusterExchange& exchange, const VectorD& albedo,
                                 const VectorD& areas, const VectorD& lit,
                                 const WindowLimits& limits);

}  // namespace prt
