// Photon mapping of a cluster's basis functions (Leonhardt & Bohn, §4.3.2): every photon carries
// all basis values of its sender at once.
#pragma once

#include <cstdint>
#include <span>

#include "scene/ray_caster.h"
#include "transport/cells.h"
#include "transport/sender_search.h"

namespace prt {

struct PhotonSettings {
  std::uint64_t photons = 0;  ///< shot from this cluster
  int bounces = -1;  ///< deposits after so many flights at most; -1: until roulette ends them
  std::uint64_t stream = 0;  ///< random stream; photon k is item k
};

/// Indirect irradiance at all samples caused by direct irradiance D_k on the cluster, all bounces.
struct PhotonTransfer {
  MatrixF irradiance;  ///< samples × (channels · k), channel-major
  std::uint64_t flights = 0;
  std::uint64_t escaped = 0;
  std::uint64_t lost = 0;  ///< landed where no sample stands
};

/// functions: k × n_c, the cluster's light basis (values at its samples). Photons start at the
/// points that measured the cluster's cells, so uniform in area over all of each cell, the parts
/// its sample does not see included; points of other clusters do not matter. They leave with cosine
/// density and weight albedo, and are counted in the cell they land in; density is power over cell
/// area. Throws UnsoundData where all bounces are wanted and light is lost more slowly than at
/// albedo 0.9999 in a closed space.
PhotonTransfer shoot_photons(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                             const SenderSearch& search, const CellPoints& points,
                             std::uint32_t cluster, const MatrixF& functions, int channels,
                             const PhotonSettings& settings);

}  // namespace prt
