#include "player/play_operators.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "player/dot.h"

namespace prt {
namespace {

/// A cluster is one piece of parallel work: no sum crosses clusters, so threads change no result.
constexpr std::size_t kClusterGrain = 1;
constexpr std::size_t kReceiverGrain = 2048;
/// The sum over senders of share · colour; colours are four floats each, red, green, blue and a
/// zero. Two senders fill a register, and eight shares are turned into floats at once.
class NearSum {
 public:
  NearSum(const NearTransfer& near, const float* colours)
      : senders_(near.senders.data()), shares_(near.shares.data()), colours_(colours) {}

  [[nodiscard]] std::array<float, 3> of(std::uint32_t begin, std::uint32_t end) const {
    EightFloats even{};
    EightFloats odd{};  // two sums side by side: an addition takes longer than a load
    std::uint32_t k = begin;
    for (; k + kLanes <= end; k += kLanes) {
      const EightFloats s = load(shares_ + k);
      even += __builtin_shufflevector(s, s, 0, 0, 0, 0, 1, 1, 1, 1) * colours_of(k, k + 1);
      odd += __builtin_shufflevector(s, s, 2, 2, 2, 2, 3, 3, 3, 3) * colours_of(k + 2, k + 3);
      even += __builtin_shufflevector(s, s, 4, 4, 4, 4, 5, 5, 5, 5) * colours_of(k + 4, k + 5);
      odd += __builtin_shufflevector(s, s, 6, 6, 6, 6, 7, 7, 7, 7) * colours_of(k + 6, k + 7);
    }
    for (; k + 2 <= end; k += 2) even += both(shares_[k], shares_[k + 1]) * colours_of(k, k + 1);
    if (k < end) odd += both(shares_[k], 0) * colours_of(k, k);
    even += odd;
    return {even[0] + even[4], even[1] + even[5], even[2] + even[6]};
  }

 private:
  [[nodiscard]] EightFloats colours_of(std::uint32_t a, std::uint32_t b) const {
    return load_two(colours_ + std::size_t{4} * senders_[a],
                    colours_ + std::size_t{4} * senders_[b]);
  }
  static EightFloats both(std::uint16_t a, std::uint16_t b) {
    const auto x = static_cast<float>(a);
    const auto y = static_cast<float>(b);
    return EightFloats{x, x, x, x, y, y, y, y};
  }

  const std::uint32_t* senders_;
  const std::uint16_t* shares_;
  const float* colours_;
};

}  // namespace

PlayProjection::PlayProjection(const ClusterProjection& projection)
    : projection_(&projection), layout_(projection.coefficient_begin()) {}

void PlayProjection::apply(const MatrixF& irradiance, const SampleSet& samples, unsigned threads,
                           MatrixF& coefficients) const {
  coefficients.resize(3, layout_.back());
  const auto& blocks = projection_->blocks;
  const auto stride = static_cast<std::size_t>(irradiance.cols());
  parallel_for(blocks.size(), kClusterGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const QuantisedMatrix& block = blocks[c];
      const float* own = irradiance.data() + samples.cluster_begin[c];
      with_numbers(block, [&](const auto* numbers) {
        for (std::size_t k = 0; k < block.rows; ++k) {
          const auto sums = dot_of_three(numbers + k * block.cols, own, stride, block.cols);
          const auto place = static_cast<Eigen::Index>(layout_[c] + k);
          for (std::size_t channel = 0; channel < 3; ++channel) {
            coefficients(static_cast<Eigen::Index>(channel), place) =
                block.scales[k] * sums[channel];
          }
        }
      });
    }
  });
}

void PlayTransfer::reduce(const ReceiverTransfer& receiver, const MatrixF& coefficients,
                          const std::vector<std::uint32_t>& layout,
                          std::vector<float>& reduced) const {
  const QuantisedMatrix& right = receiver.right;
  const std::size_t m = right.cols / transfer_->channels;
  thread_local std::vector<float> sent;  // by senders, of one channel
  sent.resize(m);
  reduced.resize(std::size_t{3} * right.rows);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    auto to = sent.begin();
    for (const std::uint32_t s : receiver.senders) {
      const float* from = &coefficients(static_cast<Eigen::Index>(channel), 0);
      to = std::copy(from + layout[s], from + layout[s + 1], to);
    }
    const std::size_t first = transfer_->channels == 1 ? 0 : channel * m;
    with_numbers(right, [&](const auto* numbers) {
      for (std::size_t k = 0; k < right.rows; ++k) {
        reduced[channel * right.rows + k] =
            right.scales[k] * dot(numbers + k * right.cols + first, sent.data(), m);
      }
    });
  }
}

void PlayTransfer::apply(const MatrixF& coefficients, const std::vector<std::uint32_t>& layout,
                         const SampleSet& samples, unsigned threads, MatrixF& irradiance) const {
  irradiance.resize(3, static_cast<Eigen::Index>(samples.size()));
  const auto& receivers = transfer_->receivers;
  parallel_for(receivers.size(), kClusterGrain, threads, [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<float> reduced;
    for (std::size_t r = begin; r < end; ++r) {
      const QuantisedMatrix& left = receivers[r].left;
      const std::size_t first = samples.cluster_begin[r];
      if (left.cols == 0 || receivers[r].right.cols == 0) {
        irradiance
            .middleCols(static_cast<Eigen::Index>(first),
                        static_cast<Eigen::Index>(samples.cluster_size(r)))
            .setZero();
        continue;
      }
      reduce(receivers[r], coefficients, layout, reduced);
      with_numbers(left, [&](const auto* numbers) {
        for (std::size_t i = 0; i < left.rows; ++i) {
          const auto sums =
              dot_of_three(numbers + i * left.cols, reduced.data(), left.cols, left.cols);
          for (std::size_t channel = 0; channel < 3; ++channel) {
            irradiance(static_cast<Eigen::Index>(channel), static_cast<Eigen::Index>(first + i)) =
                left.scales[i] * sums[channel];
          }
        }
      });
    }
  });
}

void PlayNear::apply(const MatrixF& irradiance, unsigned threads, MatrixF& exitant,
                     MatrixF& received) const {
  constexpr float kUnit = 1.0F / kUnitShare;
  const Eigen::Index n = irradiance.cols();
  exitant.resize(n, 4);
  const auto channels = static_cast<Eigen::Index>(near_->channels);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::Index channel = channels == 1 ? 0 : c;
      const std::uint16_t albedo = near_->albedo[static_cast<std::size_t>(i * channels + channel)];
      // Times π and kUnit.
      exitant(i, c) = kUnit * kUnit * static_cast<float>(albedo) * irradiance(c, i);
    }
    exitant(i, 3) = 0.0F;
  }
  received.resize(3, n);
  const NearSum sum(*near_, exitant.data());
  parallel_for(static_cast<std::size_t>(n), kReceiverGrain, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t r = begin; r < end; ++r) {
                   const auto colour = sum.of(near_->begin[r], near_->begin[r + 1]);
                   for (std::size_t c = 0; c < 3; ++c) {
                     received(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(r)) =
                         colour[c];
                   }
                 }
               });
}

PlayOperator playable(const ClusterProjection& projection) { return PlayProjection(projection); }
PlayOperator playable(const ClusterTransfer& transfer) { return PlayTransfer(transfer); }
PlayOperator playable(const NearTransfer& near) { return PlayNear(near); }

}  // namespace prt
