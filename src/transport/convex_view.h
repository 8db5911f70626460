// Clusters from which everything is seen: no depth has to be kept for them.
#pragma once

#include <optional>
#include <span>

#include "domains/directions.h"
#include "domains/samples.h"

namespace prt {

/// What the rays of samples [begin, end) met, samples × directions, as HemisphereRays has it.
struct ClusterView {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::span<const std::uint16_t> distances;
  std::span<const std::uint32_t> senders;
  float bound = 0.0F;  ///< m
};

/// The walls (bases/depth_basis.h) that all rays of a cluster end on, where these are the faces of
/// a convex space with all of the cluster in it: whatever is inside is seen, whatever is outside is
/// not. No rows where all rays escape. None where a hit lies in front of a wall, a ray was lost,
/// some rays escape and some do not (light may come in past the edge of a wall), the walls that
/// were met leave a way out to infinity, or there are more than kMostWalls: then depths are needed.
std::optional<MatrixF> convex_walls(const SampleSet& samples,
                                    const HemisphereDirections& directions,
                                    const ClusterView& view);

}  // namespace prt
