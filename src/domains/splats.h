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
  /// `samples` must outlive the field.
  explicit SplatField(const SampleSet& samples);

  /// Weights (sum 1) of the samples that reach the point; `normal` is the unit geometric normal on
  /// the side asked for. Where no kernel reaches, the nearest compatible sample within a few radii
  /// has all the weight; empty if there is none either: outside every splat. Thread-safe.
  void weights_at(const Vec3f& position, const Vec3f& normal, std::vector<SplatWeight>& out) const;

 private:
  [[nodiscard]] float kernel(std::uint32_t sample, const Vec3f& position,
                             const Vec3f& normal) const;

  const SampleSet* samples_;
  SampleGrid grid_;
  float largest_radius_ = 0.0F;  // of a kernel, m
  float reach_ = 0.0F;           // m
};

}  // namespace prt
