#include "transport/gather.h"

#include <array>

#include "transport/hemisphere.h"

namespace prt {

namespace {

constexpr Eigen::Index kLane = kGatherLane;

MatrixF pad_columns(const MatrixF& m) {
  MatrixF out = MatrixF::Zero(m.rows(), padded_to_lanes(m.cols()));
  out.leftCols(m.cols()) = m;
  return out;
}

/// out += weight · row for `width` floats, a multiple of kLane.
inline void add_scaled(float* __restrict out, const float* __restrict row, float weight,
                       Eigen::Index width) {
  for (Eigen::Index lane = 0; lane < width; lane += kLane) {
    for (Eigen::Index i = 0; i < kLane; ++i) out[lane + i] += weight * row[lane + i];
  }
}

/// Adds up the weights of one receiver's rays by the sample they hit: near samples are hit many
/// times, and each then costs one row instead of many.
class HitWeights {
 public:
  explicit HitWeights(Eigen::Index samples) : weight_(static_cast<std::size_t>(samples), 0.0F) {}

  void collect(std::span<const std::uint32_t> senders, std::span<const float> weights) {
    for (const std::uint32_t j : hit_) weight_[j] = 0.0F;
    hit_.clear();
    for (std::size_t d = 0; d < weights.size(); ++d) {
      const std::uint32_t j = senders[d];
      if (j >= kLostSender) continue;
      if (weight_[j] == 0.0F) hit_.push_back(j);
      weight_[j] += weights[d];
    }
  }
  [[nodiscard]] const std::vector<std::uint32_t>& hit() const { return hit_; }
  [[nodiscard]] float operator[](std::uint32_t j) const { return weight_[j]; }

 private:
  std::vector<float> weight_;
  std::vector<std::uint32_t> hit_;
};

}  // namespace

GatherEntries gather_entries(std::span<const std::uint32_t> senders, std::span<const float> weights,
                             std::size_t samples, float least) {
  GatherEntries entries;
  entries.begin = {0};
  HitWeights hits(static_cast<Eigen::Index>(samples));
  for (std::size_t first = 0; first < senders.size(); first += weights.size()) {
    hits.collect(senders.subspan(first, weights.size()), weights);
    for (const std::uint32_t j : hits.hit()) {
      if (!(hits[j] > least)) continue;
      entries.senders.push_back(j);
      entries.shares.push_back(hits[j]);
    }
    entries.begin.push_back(static_cast<std::uint32_t>(entries.senders.size()));
  }
  return entries;
}

std::vector<MatrixF> gather_functions(std::span<const std::uint32_t> senders,
                                      std::span<const float> weights, const MatrixF& albedo,
                                      const ClusterFunctions& functions,
                                      std::span<const std::uint32_t> cluster_of_sample) {
  const std::size_t directions = weights.size();
  const auto receivers = static_cast<Eigen::Index>(senders.size() / directions);
  const MatrixF made_wider =
      functions.values.cols() % kLane == 0 ? MatrixF() : pad_columns(functions.values);
  const MatrixF& values = made_wider.size() > 0 ? made_wider : functions.values;
  const Eigen::Index width = values.cols();
  const auto clusters = static_cast<Eigen::Index>(functions.begin.size() - 1);
  const Eigen::Index channels = albedo.cols();
  // One receiver's sums, cluster by cluster and channel by channel, stay in the first-level cache.
  MatrixF sums = MatrixF::Zero(clusters, channels * width);
  std::vector<std::uint32_t> seen;  // clusters whose sums are not zero
  std::vector<bool> is_seen(static_cast<std::size_t>(clusters), false);
  std::vector<MatrixF> result(channels, MatrixF::Zero(receivers, functions.count()));
  HitWeights hits(albedo.rows());
  for (Eigen::Index r = 0; r < receivers; ++r) {
    hits.collect(senders.subspan(r * directions, directions), weights);
    for (const std::uint32_t j : hits.hit()) {
      const std::uint32_t k = cluster_of_sample[j];
      if (!is_seen[k]) {
        is_seen[k] = true;
        seen.push_back(k);
      }
      const float* row = values.data() + j * width;
      float* out = sums.data() + k * channels * width;
      for (Eigen::Index c = 0; c < channels; ++c) {
        add_scaled(out + c * width, row, hits[j] * albedo(j, c), width);
      }
    }
    for (const std::uint32_t k : seen) {
      for (Eigen::Index c = 0; c < channels; ++c) {
        result[c].row(r).segment(functions.begin[k], functions.of(k)) =
            sums.row(k).segment(c * width, functions.of(k));
      }
      sums.row(k).setZero();
      is_seen[k] = false;
    }
    seen.clear();
  }
  return result;
}

namespace {

/// out += Σ weight · row of four rows: sums are loaded and stored a quarter as often.
inline void add_four(float* __restrict out, const std::array<const float*, 4>& row,
                     const std::array<float, 4>& weight, Eigen::Index width) {
  for (Eigen::Index lane = 0; lane < width; lane += kLane) {
    for (Eigen::Index i = 0; i < kLane; ++i) {
      out[lane + i] += (weight[0] * row[0][lane + i] + weight[1] * row[1][lane + i]) +
                       (weight[2] * row[2][lane + i] + weight[3] * row[3][lane + i]);
    }
  }
}

}  // namespace

MatrixF gather_rows(std::span<const std::uint32_t> senders, std::span<const float> weights,
                    std::span<const float* const> rows, Eigen::Index width) {
  const std::size_t directions = weights.size();
  const std::size_t receivers = senders.size() / directions;
  MatrixF sums = MatrixF::Zero(static_cast<Eigen::Index>(receivers), width);
  HitWeights hits(static_cast<Eigen::Index>(rows.size()));
  std::array<const float*, 4> row{};
  std::array<float, 4> weight{};
  for (std::size_t r = 0; r < receivers; ++r) {
    hits.collect(senders.subspan(r * directions, directions), weights);
    float* out = sums.data() + static_cast<Eigen::Index>(r) * width;
    std::size_t waiting = 0;
    for (const std::uint32_t j : hits.hit()) {
      if (rows[j] == nullptr) continue;
      row[waiting] = rows[j];
      weight[waiting++] = hits[j];
      if (waiting < row.size()) continue;
      add_four(out, row, weight, width);
      waiting = 0;
    }
    for (std::size_t k = 0; k < waiting; ++k) add_scaled(out, row[k], weight[k], width);
  }
  return sums;
}

std::vector<MatrixF> gather_fields(const GatherEntries& entries, const MatrixF& albedo,
                                   const std::vector<MatrixF>& fields) {
  const auto receivers = static_cast<Eigen::Index>(entries.begin.size()) - 1;
  const auto channels = static_cast<Eigen::Index>(fields.size());
  const Eigen::Index width = padded_to_lanes(fields[0].cols());
  // Channels side by side: one look-up per entry. Albedo goes in beforehand.
  MatrixF exitant = MatrixF::Zero(fields[0].rows(), channels * width);
  for (Eigen::Index c = 0; c < channels; ++c) {
    exitant.middleCols(c * width, fields[c].cols()) =
        albedo.col(std::min(c, albedo.cols() - 1)).asDiagonal() * fields[c];
  }
  MatrixF sums = MatrixF::Zero(receivers, exitant.cols());
  for (Eigen::Index r = 0; r < receivers; ++r) {
    for (std::uint32_t k = entries.begin[r]; k < entries.begin[r + 1]; ++k) {
      add_scaled(sums.data() + r * exitant.cols(),
                 exitant.data() + entries.senders[k] * exitant.cols(), entries.shares[k],
                 exitant.cols());
    }
  }
  std::vector<MatrixF> result;
  for (Eigen::Index c = 0; c < channels; ++c) {
    result.emplace_back(sums.middleCols(c * width, fields[c].cols()));
  }
  return result;
}

}  // namespace prt
