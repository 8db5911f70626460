// Linear operators between spaces of a clustered scene, as packages hold them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "operators/quantised.h"

namespace prt {

/// Projection of irradiance at samples onto each cluster's light basis (Leonhardt & Bohn, eq. 8
/// without a mean): coefficients_c = blocks[c] · irradiance_c, blocks[c] is k_c × n_c and holds
/// D_cᵀ·diag(area). The same for every colour channel.
struct ClusterProjection {
  std::vector<QuantisedMatrix> blocks;
  /// First coefficient of each cluster; clusters + 1 entries.
  [[nodiscard]] std::vector<std::uint32_t> coefficient_begin() const;
};

/// Transfer into one receiver cluster from those sender clusters that matter to it (eq. 10), all
/// channels sharing the left factor: indirect_channel = left · right_channel ·
/// coefficients_channel.
struct ReceiverTransfer {
  std::vector<std::uint32_t> senders;  ///< ascending sender clusters whose block was kept
  QuantisedMatrix left;                ///< n_r × k
  QuantisedMatrix
      right;  ///< k × (channels · m), m = Σ k_s over senders; channel-major, senders in order
};

struct ClusterTransfer {
  std::uint32_t channels = 3;  ///< 3, or 1 for a grey scene: then every light channel uses it
  std::vector<ReceiverTransfer> receivers;
};

/// One bounce between samples that fill much of each other's hemisphere, entry by entry: receiver r
/// gets Σ_k share_k · albedo_channel(sender_k) · irradiance_channel(sender_k), k in [begin[r],
/// begin[r+1]). Light that a near wall sends back changes within a few samples, which no basis of a
/// few functions per cluster can follow.
struct NearTransfer {
  std::uint32_t channels = 3;          ///< 3, or 1 for a grey scene
  std::vector<std::uint32_t> begin;    ///< n + 1
  std::vector<std::uint32_t> senders;  ///< samples
  std::vector<std::uint16_t> shares;   ///< of the hemisphere, cosine-weighted; 65535 is all of it
  std::vector<std::uint16_t> albedo;   ///< n × channels; 65535 is 1
};

/// [0, 1] as 16-bit integers, the way NearTransfer keeps shares and albedo.
inline constexpr float kUnitShare = 65535.0F;
inline std::uint16_t pack_share(float share) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0F, 1.0F) * kUnitShare));
}

}  // namespace prt
