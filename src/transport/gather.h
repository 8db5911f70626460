// The gather operator: stored hemispherical hits as one bounce of light, E = T E with
// T = G·diag(albedo) and G(s, j) the cosine-weighted share of sample s's hemisphere that cell j
// fills.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/types.h"
#include "domains/samples.h"

namespace prt {

/// Floats of one AVX register: gather_functions copies values whose columns are no multiple of it.
inline constexpr Eigen::Index kGatherLane = 8;

constexpr Eigen::Index padded_to_lanes(Eigen::Index n) {
  return (n + kGatherLane - 1) / kGatherLane * kGatherLane;
}

/// Functions on samples that live on one cluster each: function f of cluster c has values on c's
/// samples only. Rows are samples; a row holds the values of the functions of its own cluster.
struct ClusterFunctions {
  std::vector<std::uint32_t> begin;  ///< first function of each cluster; clusters + 1 entries
  MatrixF values;                    ///< samples × (most functions in a cluster), zero padded
  [[nodiscard]] std::uint32_t count() const { return begin.back(); }
  [[nodiscard]] std::uint32_t of(std::size_t cluster) const {
    return begin[cluster + 1] - begin[cluster];
  }
};

/// Entries of the one-bounce operator G for some receivers: receiver r's are [begin[r],
/// begin[r+1]).
struct GatherEntries {
  std::vector<std::uint32_t> begin;    ///< receivers + 1
  std::vector<std::uint32_t> senders;  ///< samples, each once per receiver
  std::vector<float> shares;           ///< of the receiver's hemisphere, cosine-weighted
};

/// The entries of G above `least`. `senders`, `weights` as for gather_functions; `samples`: how
/// many there are in all.
GatherEntries gather_entries(std::span<const std::uint32_t> senders, std::span<const float> weights,
                             std::size_t samples, float least = 0.0F);

/// T applied to all functions, for receiver samples [begin, end): one matrix per channel,
/// (end - begin) × functions.count(). `senders`: their hits, (end - begin) × weights.size(), as
/// HemisphereRays has them; `weights` the directions' cosine weights; `albedo` samples × channels.
std::vector<MatrixF> gather_functions(std::span<const std::uint32_t> senders,
                                      std::span<const float> weights, const MatrixF& albedo,
                                      const ClusterFunctions& functions,
                                      std::span<const std::uint32_t> cluster_of_sample);

/// For each receiver the sum of its senders' rows, each times the share of the hemisphere that the
/// sender fills: receivers × width. `senders`, `weights` as for gather_functions; `rows[j]`:
/// `width` floats of sample j, a multiple of kGatherLane, such as its exitant light; null: none.
MatrixF gather_rows(std::span<const std::uint32_t> senders, std::span<const float> weights,
                    std::span<const float* const> rows, Eigen::Index width);

/// T, as far as the entries go, applied to global fields: fields[c] is samples × m for channel c;
/// result receivers × m each.
std::vector<MatrixF> gather_fields(const GatherEntries& entries, const MatrixF& albedo,
                                   const std::vector<MatrixF>& fields);

}  // namespace prt
