// The package's operators in floats, ready to be applied to three colour channels. Internal to
// player/.
#pragma once

#include <variant>
#include <vector>

#include "domains/samples.h"
#include "operators/blocks.h"

namespace prt {

/// Irradiance at samples (n × 3) to coefficients (K × 3).
class DecodedProjection {
 public:
  explicit DecodedProjection(const ClusterProjection& projection);
  [[nodiscard]] MatrixF apply(const MatrixF& irradiance, const SampleSet& samples,
                              unsigned threads) const;
  /// First coefficient of each cluster, and K.
  [[nodiscard]] const std::vector<std::uint32_t>& layout() const { return layout_; }

 private:
  std::vector<MatrixF> blocks_;  // k_c × n_c
  std::vector<std::uint32_t> layout_;
};

/// Coefficients (K × 3) laid out as by a projection to irradiance at samples (n × 3).
class DecodedTransfer {
 public:
  explicit DecodedTransfer(const ClusterTransfer& transfer);
  [[nodiscard]] MatrixF apply(const MatrixF& coefficients, const std::vector<std::uint32_t>& layout,
                              const SampleSet& samples, unsigned threads) const;

 private:
  struct Receiver {
    MatrixF left;   // n_r × k
    MatrixF right;  // k × channels·m
    std::vector<std::uint32_t> senders;
  };
  [[nodiscard]] MatrixF reduced(const Receiver& receiver, const MatrixF& coefficients,
                                const std::vector<std::uint32_t>& layout) const;

  std::uint32_t channels_;
  std::vector<Receiver> receivers_;
};

/// Irradiance at samples (n × 3) to irradiance at samples.
class DecodedNear {
 public:
  explicit DecodedNear(const NearTransfer& near) : near_(&near) {}
  [[nodiscard]] MatrixF apply(const MatrixF& irradiance, unsigned threads) const;

 private:
  const NearTransfer* near_;
};

using DecodedOperator = std::variant<DecodedProjection, DecodedTransfer, DecodedNear>;
DecodedOperator decode(const ClusterProjection& projection);
DecodedOperator decode(const ClusterTransfer& transfer);
/// Keeps a reference to `near`.
DecodedOperator decode(const NearTransfer& near);

}  // namespace prt
