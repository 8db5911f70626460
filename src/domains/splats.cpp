#include "domains/splats.h"

#include <algorithm>
#include <cmath>

namespace prt {
namespace {

/// No sample's radius counts for more than this many medians: a kernel of a Poisson-disk set is at
/// most four times another (candidate_radius), and one absurd radius must not make every look-up
/// slow.
constexpr float kLargestRadius = 4.0F;

float median(std::vector<float> values) {
  if (values.empty()) return 1.0F;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

SplatField::SplatField(const SampleSet& samples) : samples_(&samples) {
  largest_radius_ = kLargestRadius * median(samples.radii);
  float largest = 0.0F;
  for (std::uint32_t i = 0; i < samples.size(); ++i) largest = std::max(largest, radius(i));
  largest_radius_ = largest;
  reach_ = kSplatReach * largest;
  grid_ = SampleGrid(samples.positions, samples.normals, std::max(reach_, 1e-30F));
}

float SplatField::radius(std::uint32_t sample) const {
  return std::min(samples_->radii[sample], largest_radius_);
}

float SplatField::kernel(std::uint32_t sample, const Vec3f& position, const Vec3f& normal) const {
  const Vec3f& n = samples_->normals[sample];
  const float agreement = (n.dot(normal) - kCompatibleCosine) / (1.0F - kCompatibleCosine);
  if (!(agreement > 0.0F)) return 0.0F;
  const float radius = this->radius(sample);
  const Vec3f offset = (samples_->positions[sample] - position) / radius;
  // The plane between the two tangent planes: on a sphere no chord leaves it.
  const float across = offset.dot((n + normal).normalized());
  const float along2 = offset.squaredNorm() - across * across;
  const float edge = 1.0F - along2 / (kSplatReach * kSplatReach);
  if (!(edge > 0.0F)) return 0.0F;
  const float exponent = along2 / (2.0F * kSplatSigma * kSplatSigma) +
                         across * across / (2.0F * kSplatSigmaAcross * kSplatSigmaAcross);
  return agreement * edge * edge * std::exp(-exponent);
}

void SplatField::weights_at(const Vec3f& position, const Vec3f& normal,
                            std::vector<SplatWeight>& out) const {
  out.clear();
  thread_local std::vector<std::uint32_t> near;
  near.clear();
  grid_.within(position, reach_, near);
  float total = 0.0F;
  for (const std::uint32_t sample : near) {
    const float weight = kernel(sample, position, normal);
    if (!(weight > kSmallestSplat)) continue;
    out.push_back({sample, weight});
    total += weight;
  }
  if (!out.empty()) {
    for (SplatWeight& w : out) w.weight /= total;
    return;
  }
  const std::uint32_t nearest = grid_.nearest(position, normal, kSplatFallback * largest_radius_);
  if (nearest != kNone) out.push_back({nearest, 1.0F});
}

}  // namespace prt
