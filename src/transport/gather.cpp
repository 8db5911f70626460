#include "transport/gather.h"

#include "transport/hemisphere.h"

namespace prt {

namespace {

constexpr int kLane = 8;  // floats of one AVX register

/// Adds weight · row to out, both of padded width.
inline void add_scaled(float* __restrict out, const float* __restrict row, float weight,
                       Eigen::Index width) {
  for (Eigen::Index i = 0; i < width; ++i) out[i] += weight * row[i];
}

Eigen::Index padded(Eigen::Index n) { return (n + kLane - 1) / kLane * kLane; }

MatrixF pad_columns(const MatrixF& m) {
  MatrixF out = MatrixF::Zero(m.rows(), padded(m.cols()));
  out.leftCols(m.cols()) = m;
  return out;
}

/// Calls visit(row, sender, weight) for every ray that ended at a sample.
template <typename Visit>
void for_each_hit(std::span<const std::uint32_t> senders, std::span<const float> weights,
                  Visit&& visit) {
  const std::size_t directions = weights.size();
  const std::size_t receivers = senders.size() / directions;
  for (std::size_t r = 0; r < receivers; ++r) {
    const std::uint32_t* row = senders.data() + r * directions;
    for (std::size_t d = 0; d < directions; ++d) {
      if (row[d] < kLostSender) visit(static_cast<Eigen::Index>(r), row[d], weights[d]);
    }
  }
}

}  // namespace

std::vector<MatrixF> gather_functions(std::span<const std::uint32_t> senders,
                                      std::span<const float> weights, const MatrixF& albedo,
                                      const ClusterFunctions& functions,
                                      std::span<const std::uint32_t> cluster_of_sample) {
  const auto receivers = static_cast<Eigen::Index>(senders.size() / weights.size());
  const MatrixF values = pad_columns(functions.values);
  const Eigen::Index width = values.cols();
  const auto clusters = static_cast<Eigen::Index>(functions.begin.size() - 1);
  const Eigen::Index channels = albedo.cols();
  // One receiver's sums, channel by channel and cluster by cluster, stay in the first-level cache.
  MatrixF sums(channels, clusters * width);
  std::vector<MatrixF> result(channels, MatrixF::Zero(receivers, functions.count()));
  const std::size_t directions = weights.size();
  for (Eigen::Index r = 0; r < receivers; ++r) {
    sums.setZero();
    for_each_hit(senders.subspan(r * directions, directions), weights,
                 [&](Eigen::Index, std::uint32_t j, float w) {
                   const float* row = values.data() + j * width;
                   float* out = sums.data() + cluster_of_sample[j] * width;
                   for (Eigen::Index c = 0; c < channels; ++c) {
                     add_scaled(out + c * clusters * width, row, w * albedo(j, c), width);
                   }
                 });
    for (Eigen::Index c = 0; c < channels; ++c) {
      for (Eigen::Index k = 0; k < clusters; ++k) {
        result[c].row(r).segment(functions.begin[k], functions.of(k)) =
            sums.row(c).segment(k * width, functions.of(k));
      }
    }
  }
  return result;
}

std::vector<MatrixF> gather_fields(std::span<const std::uint32_t> senders,
                                   std::span<const float> weights, const MatrixF& albedo,
                                   const std::vector<MatrixF>& fields) {
  const auto receivers = static_cast<Eigen::Index>(senders.size() / weights.size());
  const auto channels = static_cast<Eigen::Index>(fields.size());
  const Eigen::Index width = padded(fields[0].cols());
  // Channels side by side: one look-up per hit. Albedo goes in beforehand.
  MatrixF exitant = MatrixF::Zero(fields[0].rows(), channels * width);
  for (Eigen::Index c = 0; c < channels; ++c) {
    exitant.middleCols(c * width, fields[c].cols()) =
        albedo.col(std::min(c, albedo.cols() - 1)).asDiagonal() * fields[c];
  }
  MatrixF sums = MatrixF::Zero(receivers, exitant.cols());
  for_each_hit(senders, weights, [&](Eigen::Index r, std::uint32_t j, float w) {
    add_scaled(sums.data() + r * exitant.cols(), exitant.data() + j * exitant.cols(), w,
               exitant.cols());
  });
  std::vector<MatrixF> result;
  for (Eigen::Index c = 0; c < channels; ++c) {
    result.emplace_back(sums.middleCols(c * width, fields[c].cols()));
  }
  return result;
}

}  // namespace prt
