// Linear operators between spaces of a clustered scene, as packages hold them.
#pragma once

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

}  // namespace prt
