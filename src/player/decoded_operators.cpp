#include "player/decoded_operators.h"

#include "base/parallel.h"

namespace prt {
namespace {

/// A cluster is one piece of parallel work: no sum crosses clusters, so threads change no result.
constexpr std::size_t kClusterGrain = 1;
constexpr std::size_t kReceiverGrain = 2048;

}  // namespace

DecodedProjection::DecodedProjection(const ClusterProjection& projection)
    : layout_(projection.coefficient_begin()) {
  blocks_.reserve(projection.blocks.size());
  for (const QuantisedMatrix& block : projection.blocks) blocks_.push_back(block.decode());
}

MatrixF DecodedProjection::apply(const MatrixF& irradiance, const SampleSet& samples,
                                 unsigned threads) const {
  MatrixF coefficients = MatrixF::Zero(layout_.back(), 3);
  parallel_for(blocks_.size(), kClusterGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (blocks_[c].size() == 0) continue;
      coefficients.middleRows(layout_[c], blocks_[c].rows()).noalias() =
          blocks_[c] * irradiance.middleRows(samples.cluster_begin[c], samples.cluster_size(c));
    }
  });
  return coefficients;
}

DecodedTransfer::DecodedTransfer(const ClusterTransfer& transfer) : channels_(transfer.channels) {
  receivers_.reserve(transfer.receivers.size());
  for (const ReceiverTransfer& receiver : transfer.receivers) {
    receivers_.push_back({receiver.left.decode(), receiver.right.decode(), receiver.senders});
  }
}

/// right_channel · coefficients_channel, side by side: k × 3.
MatrixF DecodedTransfer::reduced(const Receiver& receiver, const MatrixF& coefficients,
                                 const std::vector<std::uint32_t>& layout) const {
  const Eigen::Index m = receiver.right.cols() / channels_;
  MatrixF sent(m, 3);
  Eigen::Index row = 0;
  for (const std::uint32_t s : receiver.senders) {
    const Eigen::Index count = layout[s + 1] - layout[s];
    sent.middleRows(row, count) = coefficients.middleRows(layout[s], count);
    row += count;
  }
  MatrixF result(receiver.right.rows(), 3);
  for (Eigen::Index channel = 0; channel < 3; ++channel) {
    const Eigen::Index first = channels_ == 1 ? 0 : channel * m;
    result.col(channel) = receiver.right.middleCols(first, m) * sent.col(channel);
  }
  return result;
}

MatrixF DecodedTransfer::apply(const MatrixF& coefficients,
                               const std::vector<std::uint32_t>& layout, const SampleSet& samples,
                               unsigned threads) const {
  MatrixF irradiance = MatrixF::Zero(static_cast<Eigen::Index>(samples.size()), 3);
  parallel_for(receivers_.size(), kClusterGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      if (receivers_[r].left.size() == 0 || receivers_[r].right.size() == 0) continue;
      irradiance.middleRows(samples.cluster_begin[r], samples.cluster_size(r)).noalias() =
          receivers_[r].left * reduced(receivers_[r], coefficients, layout);
    }
  });
  return irradiance;
}

MatrixF DecodedNear::apply(const MatrixF& irradiance, unsigned threads) const {
  constexpr float kUnit = 1.0F / kUnitShare;
  const auto n = static_cast<std::size_t>(irradiance.rows());
  // A colour fills a vector register: senders lie anywhere, and one load fetches all of one.
  std::vector<Eigen::Array4f> exitant(n);  // times π and kUnit
  for (std::size_t i = 0; i < n; ++i) {
    exitant[i].setZero();
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t channel = near_->channels == 1 ? 0 : c;
      const float albedo = kUnit * static_cast<float>(near_->albedo[i * near_->channels + channel]);
      exitant[i][c] = kUnit * albedo * irradiance(i, c);
    }
  }
  MatrixF received(irradiance.rows(), 3);
  parallel_for(n, kReceiverGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      Eigen::Array4f sum = Eigen::Array4f::Zero();
      for (std::uint32_t k = near_->begin[r]; k < near_->begin[r + 1]; ++k) {
        sum += static_cast<float>(near_->shares[k]) * exitant[near_->senders[k]];
      }
      received.row(r) = sum.head<3>();
    }
  });
  return received;
}

DecodedOperator decode(const ClusterProjection& projection) {
  return DecodedProjection(projection);
}
DecodedOperator decode(const ClusterTransfer& transfer) { return DecodedTransfer(transfer); }
DecodedOperator decode(const NearTransfer& near) { return DecodedNear(near); }

}  // namespace prt
