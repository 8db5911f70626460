// The package's operators, ready to be applied to three colour channels. They keep references to
// it: its integers are multiplied as they are. Internal to player/.
#pragma once

#include <variant>
#include <vector>

#include "domains/samples.h"
#include "operators/blocks.h"

namespace prt {

// Values are planes, one per channel: irradiance at samples 3 × n, coefficients 3 × K. Outputs are
// resized; of the right size already, nothing is allocated.

/// Irradiance at samples to coefficients.
class PlayProjection {
 public:
  explicit PlayProjection(const ClusterProjection& projection);
  void apply(const MatrixF& irradiance, const SampleSet& samples, unsigned threads,
             MatrixF& coefficients) const;
  /// First coefficient of each cluster, and K.
  [[nodiscard]] const std::vector<std::uint32_t>& layout() const { return layout_; }

 private:
  const ClusterProjection* projection_;
  std::vector<std::uint32_t> layout_;
};

/// Coefficients laid out as by a projection to irradiance at samples.
class PlayTransfer {
 public:
  explicit PlayTransfer(const ClusterTransfer& transfer) : transfer_(&transfer) {}
  void apply(const MatrixF& coefficients, const std::vector<std::uint32_t>& layout,
             const SampleSet& samples, unsigned threads, MatrixF& irradiance) const;

 private:
  /// right_channel · coefficients_channel: 3 × k.
  void reduce(const ReceiverTransfer& receiver, const MatrixF& coefficients,
              const std::vector<std::uint32_t>& layout, std::vector<float>& reduced) const;

  const ClusterTransfer* transfer_;
};

/// Irradiance at samples to irradiance at samples.
class PlayNear {
 public:
  explicit PlayNear(const NearTransfer& near) : near_(&near) {}
  /// `exitant` is overwritten: n × 4, a colour and a zero for each sample.
  void apply(const MatrixF& irradiance, unsigned threads, MatrixF& exitant,
             MatrixF& received) const;

 private:
  const NearTransfer* near_;
};

using PlayOperator = std::variant<PlayProjection, PlayTransfer, PlayNear>;
PlayOperator playable(const ClusterProjection& projection);
PlayOperator playable(const ClusterTransfer& transfer);
PlayOperator playable(const NearTransfer& near);

}  // namespace prt
