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
                         const std::vector<std::uint32_t>& begin, const MatrixF& typical,
                         double tolerance) {
  const std::size_t clusters = begin.size() - 1;
  std::vector<double> energy(clusters, 0.0);
  const VectorF root = areas.cwiseSqrt();
  for (std::size_t s = 0; s < clusters; ++s) {
    const Eigen::Index k = begin[s + 1] - begin[s];
    // ‖M C‖² over the lights from C's small covariance.
    const MatrixD light = typical.middleRows(begin[s], k).cast<double>();
    const MatrixD covariance = light * light.transpose();
    for (const MatrixF& m : transfer) {
      const MatrixD block = (root.asDiagonal() * m.middleCols(begin[s], k)).cast<double>();
      energy[s] += (block.transpose() * block).cwiseProduct(covariance).sum();
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

/// Rows of the kept senders' functions.
MatrixF kept_rows(const MatrixF& typical, const std::vector<std::uint32_t>& begin,
                  const std::vector<std::uint32_t>& senders) {
  Eigen::Index height = 0;
  for (const auto s : senders) height += begin[s + 1] - begin[s];
  MatrixF kept(height, typical.cols());
  Eigen::Index row = 0;
  for (const auto s : senders) {
    const Eigen::Index k = begin[s + 1] - begin[s];
    kept.middleRows(row, k) = typical.middleRows(begin[s], k);
    row += k;
  }
  return kept;
}

/// Light received from typical coefficients, lights of all channels side by side.
MatrixF received(const MatrixF& joined, const MatrixF& typical) {
  const Eigen::Index channels = typical.rows() > 0 ? joined.cols() / typical.rows() : 0;
  MatrixF fields(joined.rows(), channels * typical.cols());
  for (Eigen::Index c = 0; c < channels; ++c) {
    fields.middleCols(c * typical.cols(), typical.cols()).noalias() =
        joined.middleCols(c * typical.rows(), typical.rows()) * typical;
  }
  return fields;
}

}  // namespace

Artifact compress_transfer(const std::vector<MatrixF>& transfer, const VectorF& areas,
                           const std::vector<std::uint32_t>& function_begin, const MatrixF& typical,
                           const TransferCompression& settings) {
  const Kept kept =
      keep_strong_senders(transfer, areas, function_begin, typical, settings.tolerance);
  const MatrixF full = join_kept(transfer, function_begin, kept.senders);
  const MatrixF lights = kept_rows(typical, function_begin, kept.senders);
  const MatrixF fields = received(full, lights);
  const LowRank low = low_rank(full, areas, fields, settings.rank, settings.tolerance);
  const Quantised left = quantise(low.left, settings.bits);
  const Quantised right = quantise(low.right, settings.bits);
  const VectorF root = areas.cwiseSqrt();
  const double total = (root.asDiagonal() * fields).cast<double>().squaredNorm();
  const MatrixF again = left.matrix.decode() * received(right.matrix.decode(), lights);
  const double off = (root.asDiagonal() * (again - fields)).cast<double>().squaredNorm();
  const auto relative = [&](double squared) {
    return total > 0.0 ? std::sqrt(squared / total) : 0.0;
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
