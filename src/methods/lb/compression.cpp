#include <algorithm>
#include <cmath>
#include <numeric>

#include "methods/lb/tasks.h"
#include "operators/low_rank.h"
#include "store/quantised_io.h"

namespace prt::lb {

namespace {

// Dropped blocks may take this share of the tolerance; the rest is for rank and rounding.
constexpr double kDropShare = 0.1;

struct Kept {
  std::vector<std::uint32_t> senders;
  double dropped_energy = 0.0;  ///< squared norm
  double total_energy = 0.0;
};

/// Leaves out the weakest sender clusters as long as all of them together stay below the limit.
Kept keep_strong_senders(const std::vector<MatrixF>& transfer, const VectorF& areas,
                         const std::vector<std::uint32_t>& begin, double tolerance) {
  const std::size_t clusters = begin.size() - 1;
  std::vector<double> energy(clusters, 0.0);
  const VectorF root = areas.cwiseSqrt();
  for (std::size_t s = 0; s < clusters; ++s) {
    for (const MatrixF& m : transfer) {
      energy[s] += (root.asDiagonal() * m.middleCols(begin[s], begin[s + 1] - begin[s]))
                       .cast<double>()
                       .squaredNorm();
    }
  }
  Kept kept;
  kept.total_energy = std::accumulate(energy.begin(), energy.end(), 0.0);
  std::vector<std::uint32_t> order(clusters);
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return energy[a] < energy[b]; });
  const double limit = kDropShare * kDropShare * tolerance * tolerance * kept.total_energy;
  for (const std::uint32_t s : order) {
    if (kept.dropped_energy + energy[s] <= limit) {
      kept.dropped_energy += energy[s];
    } else {
      kept.senders.push_back(s);
    }
  }
  std::sort(kept.senders.begin(), kept.senders.end());
  return kept;
}

MatrixF join_kept(const std::vector<MatrixF>& transfer, const std::vector<std::uint32_t>& begin,
                  const std::vector<std::uint32_t>& senders) {
  Eigen::Index width = 0;
  for (const auto s : senders) width += begin[s + 1] - begin[s];
  MatrixF joined(transfer[0].rows(), width * static_cast<Eigen::Index>(transfer.size()));
  Eigen::Index column = 0;
  for (const MatrixF& m : transfer) {
    for (const auto s : senders) {
      const Eigen::Index k = begin[s + 1] - begin[s];
      joined.middleCols(column, k) = m.middleCols(begin[s], k);
      column += k;
    }
  }
  return joined;
}

}  // namespace

Artifact compress_transfer(const std::vector<MatrixF>& transfer, const VectorF& areas,
                           const std::vector<std::uint32_t>& function_begin,
                           const TransferCompression& settings) {
  const Kept kept = keep_strong_senders(transfer, areas, function_begin, settings.tolerance);
  const MatrixF full = join_kept(transfer, function_begin, kept.senders);
  // Light functions are scaled so that all coefficients have typical size 1: columns weigh alike.
  const LowRank low =
      low_rank(full, areas, VectorF::Ones(full.cols()), settings.rank, settings.tolerance);
  const Quantised left = quantise(low.left, settings.bits);
  const Quantised right = quantise(low.right, settings.bits);
  const MatrixF again = left.matrix.decode() * right.matrix.decode();
  const double off = (areas.cwiseSqrt().asDiagonal() * (again - full)).cast<double>().squaredNorm();
  const auto relative = [&](double squared) {
    return kept.total_energy > 0.0 ? std::sqrt(squared / kept.total_energy) : 0.0;
  };
  Artifact out;
  put_quantised(out, "left", left.matrix, "1", "receiver samples in the transfer's left factor");
  put_quantised(out, "right", right.matrix, "W/m^2",
                "right factor: sender functions, channels side by side");
  out.put<std::uint32_t>("senders", kept.senders, {kept.senders.size()}, "1",
                         "sender clusters kept");
  out.attributes = {{"channels", transfer.size()},
                    {"rank", low.left.cols()},
                    {"energy", 1.0 - low.relative_error * low.relative_error},
                    {"error_dropped", relative(kept.dropped_energy)},
                    {"error_low_rank", low.relative_error},
                    {"error_left_rounding", left.relative_error},
                    {"error_right_rounding", right.relative_error},
                    {"error", relative(off + kept.dropped_energy)}};
  return out;
}

}  // namespace prt::lb
