// Cells of samples: the part of the reachable surface each sample stands for, measured by points
// uniform in area.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/ray_caster.h"
#include "transport/area_points.h"
#include "transport/sender_search.h"

namespace prt {

/// Area-uniform points that lie in cells; point k of all `total` stands for `area_per_point` on one
/// side.
struct CellPoints {
  std::vector<std::uint32_t> samples;  ///< the sample whose cell the point lies in
  std::vector<std::uint32_t> triangles;
  std::vector<float> barycentric;  ///< 2 per point: weights of vertices 1 and 2
};

/// Points first..first+count of `total` points stratified over the whole surface, on both sides. A
/// point is kept if a compatible sample is near and the point can be reached: the sample is seen
/// from it, or a ray from it ends on reachable surface. So hidden surface (below a box, inside a
/// solid) is kept out.
CellPoints draw_cell_points(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                            const SenderSearch& search, const std::vector<double>& cumulative,
                            std::uint64_t total, std::uint64_t first, std::uint64_t count,
                            std::uint64_t stream);

}  // namespace prt
