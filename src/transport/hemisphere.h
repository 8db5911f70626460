// The one hemispherical ray cast per sample that feeds depth buffers and the gather operator
// (Leonhardt & Bohn, §4.2, figure 2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "domains/directions.h"
#include "scene/ray_caster.h"
#include "transport/sender_search.h"

namespace prt {

/// Sender of a ray that left the scene, and of one that hit surface no sample stands for.
inline constexpr std::uint32_t kEscapedSender = kNone;
inline constexpr std::uint32_t kLostSender = kNone - 1;

/// What the rays of samples [begin, end) met; samples × directions, row-major.
struct HemisphereRays {
  std::vector<std::uint16_t> distances;  ///< bases/depth_basis.h: pack_depth
  std::vector<std::uint32_t> senders;    ///< sample hit, kEscapedSender or kLostSender
  /// Cosine-weighted shares over these samples, weighted by area: gathered + escaped + lost = 1.
  double escaped_share = 0.0;
  double lost_share = 0.0;
  std::uint64_t back_hits = 0;  ///< rays that met a back face
};

/// Casts directions.count() rays from each sample in the range. `bound` (m) is the depth of an
/// escape.
HemisphereRays cast_hemispheres(const Scene& scene, const RayCaster& caster,
                                const SampleSet& samples, const SenderSearch& search,
                                const HemisphereDirections& directions, std::uint32_t begin,
                                std::uint32_t end, float bound);

}  // namespace prt
