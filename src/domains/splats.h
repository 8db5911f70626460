// Reconstruction of sample values at any surface point by normalised elliptical kernels
// (Leonhardt & Bohn, §5: Gaussian elliptical splats).
#pragma once

#include <span>
#include <vector>

#include "domains/samples.h"

namespace prt {

struct SplatWeight {
  std::uint32_t sample;
  float weight;
};

/// Each sample is a disk in its tangent plane with a Gaussian kernel, seen as an ellipse from
/// anywhere else; a point takes the normalised sum of the kernels that reach it from a compatible
/// side.
class SplatField {
 public:
  explicit SplatField(const SampleSet& samples);

  /// Weights (sum 1) of the samples that reach the point; empty if none does: outside every splat.
  void weights_at(const Vec3f& position, const Vec3f& normal, std::vector<SplatWeight>& out) const;

 private:
  const SampleSet* samples_;
  SampleGrid grid_;
  float reach_ = 0.0F;
};

}  // namespace prt
