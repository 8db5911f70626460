#include "transport/near_series.h"

namespace prt {

namespace {

/// A sparse row over all samples, with a weight per channel.
class SparseRow {
 public:
  SparseRow(std::size_t samples, Eigen::Index channels)
      : slot_(samples, kNone), channels_(static_cast<std::size_t>(channels)) {}
  /// Weights of a sample, zero at first, to be added to. Valid until the next call.
  float* at(std::uint32_t sample) {
    if (slot_[sample] == kNone) {
      slot_[sample] = static_cast<std::uint32_t>(samples_.size());
      samples_.push_back(sample);
      weights_.resize(weights_.size() + channels_, 0.0F);
    }
    return weights_.data() + slot_[sample] * channels_;
  }
  void clear() {
    for (const std::uint32_t s : samples_) slot_[s] = kNone;
    samples_.clear();
    weights_.clear();
  }
  [[nodiscard]] const std::vector<std::uint32_t>& samples() const { return samples_; }
  [[nodiscard]] const std::vector<float>& weights() const { return weights_; }

 private:
  std::vector<std::uint32_t> slot_;  // of each sample; kNone: not in the row
  std::vector<std::uint32_t> samples_;
  std::vector<float> weights_;  // samples_.size() × channels_
  std::size_t channels_;
};

}  // namespace

NearSeries near_series(const GatherEntries& near, const MatrixF& albedo, std::uint32_t first,
                       std::uint32_t end, int bounces) {
  const Eigen::Index channels = albedo.cols();
  const auto samples = static_cast<std::size_t>(albedo.rows());
  SparseRow sum(samples, channels), power(samples, channels), next(samples, channels);
  NearSeries series;
  series.begin = {0};
  std::vector<float> weights;
  // Adds `factor` (per channel) times row s of N.
  const auto add_row = [&](std::uint32_t s, const float* factor, SparseRow& row) {
    for (std::uint32_t k = near.begin[s]; k < near.begin[s + 1]; ++k) {
      const std::uint32_t j = near.senders[k];
      float* to = row.at(j);
      for (Eigen::Index c = 0; c < channels; ++c) {
        to[c] += factor[c] * near.shares[k] * albedo(j, c);
      }
    }
  };
  const std::vector<float> one(static_cast<std::size_t>(channels), 1.0F);
  for (std::uint32_t r = first; r < end; ++r) {
    sum.clear();
    power.clear();
    add_row(r, one.data(), power);
    for (int bounce = 1;; ++bounce) {
      for (std::size_t i = 0; i < power.samples().size(); ++i) {
        float* to = sum.at(power.samples()[i]);
        for (Eigen::Index c = 0; c < channels; ++c) to[c] += power.weights()[i * channels + c];
      }
      if (bounce >= bounces) break;
      next.clear();
      for (std::size_t i = 0; i < power.samples().size(); ++i) {
        add_row(power.samples()[i], power.weights().data() + i * channels, next);
      }
      std::swap(power, next);
    }
    series.senders.insert(series.senders.end(), sum.samples().begin(), sum.samples().end());
    weights.insert(weights.end(), sum.weights().begin(), sum.weights().end());
    series.begin.push_back(static_cast<std::uint32_t>(series.senders.size()));
  }
  series.weights = Eigen::Map<const MatrixF>(
      weights.data(), static_cast<Eigen::Index>(series.senders.size()), channels);
  return series;
}

void subtract_series(const NearSeries& series, const ClusterFunctions& functions,
                     std::span<const std::uint32_t> cluster_of_sample,
                     std::vector<MatrixF>& transfer) {
  for (std::size_t r = 0; r + 1 < series.begin.size(); ++r) {
    for (std::uint32_t k = series.begin[r]; k < series.begin[r + 1]; ++k) {
      const std::uint32_t j = series.senders[k];
      const std::uint32_t cluster = cluster_of_sample[j];
      const Eigen::Index count = functions.of(cluster);
      for (std::size_t c = 0; c < transfer.size(); ++c) {
        transfer[c].row(static_cast<Eigen::Index>(r)).segment(functions.begin[cluster], count) -=
            series.weights(k, static_cast<Eigen::Index>(c)) * functions.values.row(j).head(count);
      }
    }
  }
}

}  // namespace prt
