// Reconstruction of sample values at any surface point by normalised elliptical kernels
// (Leonhardt & Bohn, §5: Gaussian elliptical splats).
#pragma once

#include <span>
#include <vector>

#include "domains/samples.h"

namespace prt {

/// Standard deviation of a kernel in its tangent plane, in Poisson-disk radii. Chosen by measuring
/// (splats_test): ERROR OF SMOOTH FUNCTIONS.
inline constexpr float kSplatSigma = 0.6F;
/// A kernel ends here, in radii. A maximal Poisson-disk set leaves no point farther than one radius
/// from a sample; the rest is margin for places where candidates were few.
inline constexpr float kSplatReach = 2.0F;
/// Standard deviation across the surface, in radii: parallel sheets a third of a radius apart
/// hardly mix.
inline constexpr float kSplatSigmaAcross = 0.1F;
/// Kernels weaker than this are left out: they would only slow things down, or underflow.
inline constexpr float kSmallestSplat = 1e-12F;
/// Where no kernel reaches: the nearest compatible sample within this many of the largest radius.
inline constexpr float kSplatFallback = 4.0F;

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

  /// Radius of a sample's kernel, m; none is larger than largest_radius().
  [[nodiscard]] float radius(std::uint32_t sample) const;
  [[nodiscard]] float largest_radius() const { return largest_radius_; }

 private:
  [[nodiscard]] float kernel(std::uint32_t sample, const Vec3f& position,
                             const Vec3f& normal) const;

  const SampleSet* samples_;
  SampleGrid grid_;
  float largest_radius_ = 0.0F;  // of a kernel, m
  float reach_ = 0.0F;           // m
};

}  // namespace prt
