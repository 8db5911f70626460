#include "transport/sender_search.h"

#include <algorithm>

namespace prt {

namespace {

// Thinning is maximal over its candidates, not over the surface: a little beyond the radius is
// normal.
constexpr float kReach = 1.25F;
// Cells much wider than the reach: few are looked into, and a scan in memory order is cheap.
// Measured on the gallery at 45,000 samples: 0.68 us per ray in all at 1.25 radii, 0.48 at 3.25.
constexpr float kCell = 3.25F;
// Beyond this many radii there is no telling which sample would stand for a point.
constexpr float kFar = 4.0F;

float largest(const std::vector<float>& radii) {
  return radii.empty() ? 1.0F : *std::max_element(radii.begin(), radii.end());
}

}  // namespace

SenderSearch::SenderSearch(const SampleSet& samples)
    : samples_(&samples),
      grid_(samples.positions, samples.normals, kCell * largest(samples.radii)),
      reach_(largest(samples.radii)) {}

std::uint32_t SenderSearch::find(const Scene& scene, const SurfacePoint& point) const {
  for (const float reach : {kReach * reach_, kFar * reach_}) {
    const auto sample = grid_.nearest(point.position, point.normal, reach);
    if (sample != kNone) return sample;
  }
  const auto sample = grid_.nearest(point.position, point.normal, kFar * reach_, 0.0F);
  if (sample == kNone) return kNone;
  const bool same = scene.triangles[samples_->triangles[sample]].surface ==
                    scene.triangles[point.triangle].surface;
  return same ? sample : kNone;
}

std::uint32_t SenderSearch::find_near(const Vec3f& position, const Vec3f& normal) const {
  return grid_.nearest(position, normal, kReach * reach_);
}

}  // namespace prt
