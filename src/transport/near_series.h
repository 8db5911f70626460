// Light that goes to and fro between samples that fill much of each other's hemisphere.
#pragma once

#include "transport/gather.h"

namespace prt {

/// Rows of N + N² + … + N^bounces for some receivers, N(s, j) = share(s, j)·albedo_c(j): receiver
/// r's entries are [begin[r], begin[r+1]).
struct NearSeries {
  std::vector<std::uint32_t> begin;    ///< receivers + 1
  std::vector<std::uint32_t> senders;  ///< samples, each once per receiver
  MatrixF weights;                     ///< entries × channels
};

/// Rows of receivers [first, end). `near`: the entries of all samples; `albedo` samples × channels.
NearSeries near_series(const GatherEntries& near, const MatrixF& albedo, std::uint32_t first,
                       std::uint32_t end, int bounces);

/// transfer[c] −= series_c · functions, for the transfer of these receivers (receivers ×
/// functions.count() per channel).
void subtract_series(const NearSeries& series, const ClusterFunctions& functions,
                     std::span<const std::uint32_t> cluster_of_sample,
                     std::vector<MatrixF>& transfer);

}  // namespace prt
