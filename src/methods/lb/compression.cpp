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
/// projected: transfer in an orthonormal left factor, k × functions per channel.
Kept keep_strong_senders(const std::vector<MatrixF>& projected,
                         const std::vector<std::uint32_t>& begin, const MatrixF& typical,
                         double tolerance) {
  const std::size_t clusters = begin.size() - 1;
  std::vector<double> energy(clusters, 0.0);
  for (std::size_t s = 0; s < clusters; ++s) {
    const Eigen::Index k = begin[s + 1] - begin[s];
    // ‖M C‖² over the lights from C's small covariance.
    const MatrixD light = typical.middleRows(begin[s], k).cast<double>();
    const MatrixD covariance = light * light.transpose();
    for (const MatrixF& m : projected) {
      const MatrixD block = m.middleCols(begin[s], k).cast<double>();
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

/// Columns of the kept senders' functions, channels side by side.
MatrixF join_kept(const std::vector<MatrixF>& projected, const std::vector<std::uint32_t>& begin,
                  const std::vector<std::uint32_t>& senders) {
  Eigen::Index width = 0;
  for (const auto s : senders) width += begin[s + 1] - begin[s];
  MatrixF joined(projected[0].rows(), width * static_cast<Eigen::Index>(projected.size()));
  Eigen::Index column = 0;
  for (const MatrixF& m : projected) {
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

MatrixF side_by_side(const std::vector<MatrixF>& parts) {
  Eigen::Index width = 0;
  for (const MatrixF& part : parts) width += part.cols();
  MatrixF all(parts[0].rows(), width);
  Eigen::Index column = 0;
  for (const MatrixF& part : parts) {
    all.middleCols(column, part.cols()) = part;
    column += part.cols();
  }
  return all;
}

MatrixF ChannelTransfer::projected(const MatrixF& rows) const {
  MatrixF all = rows * once;
  if (solution) all.noalias() += MatrixF(rows * further) * *solution;
  return all;
}

Artifact compress_transfer(const std::vector<ChannelTransfer>& transfer,
                           const std::vector<MatrixF>& fields, const VectorF& areas,
                           const std::vector<std::uint32_t>& function_begin, const MatrixF& typical,
                           const TransferCompression& settings) {
  const MatrixF received_in_full = side_by_side(fields);
  LeftFactor factor = left_factor(received_in_full, areas, settings.rank, settings.tolerance);
  std::vector<MatrixF> projected;
  projected.reserve(transfer.size());
  for (const ChannelTransfer& t : transfer) projected.push_back(t.projected(factor.dual));
  const Kept kept = keep_strong_senders(projected, function_begin, typical, settings.tolerance);
  MatrixF full_right = join_kept(projected, function_begin, kept.senders);
  balance(factor.functions, full_right);
  const MatrixF lights = kept_rows(typical, function_begin, kept.senders);
  const Quantised left = quantise(factor.functions, settings.bits);
  const Quantised right = quantise(full_right, settings.bits);
  const VectorF root = areas.cwiseSqrt();
  const double total = (root.asDiagonal() * received_in_full).cast<double>().squaredNorm();
  const MatrixF again = left.matrix.decode() * received(right.matrix.decode(), lights);
  // A cluster in the dark keeps no sender at all.
  const double off =
      again.cols() == 0
          ? total
          : (root.asDiagonal() * (again - received_in_full)).cast<double>().squaredNorm();
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
                    {"rank", factor.functions.cols()},
                    {"energy", 1.0 - factor.relative_error * factor.relative_error},
                    {"error_dropped", relative(kept.dropped_energy)},
                    {"error_low_rank", factor.relative_error},
                    {"error_left_rounding", left.relative_error},
                    {"error_right_rounding", right.relative_error},
                    {"error", relative(off)}};
  return out;
}

}  // namespace prt::lb
