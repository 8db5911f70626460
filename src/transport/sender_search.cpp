#include "transport/sender_search.h"

#include <algorithm>
#include <cassert>

namespace prt {

namespace {

// Thinning is maximal over its candidates, not over the surface: a little beyond the radius is
// normal.
constexpr float kReach = 1.25F;
// Cells much wider than the reach: few are looked into, and a scan in memory order is cheap.
constexpr float kCell = 3.25F;
// Beyond this many radii within its plane, or one off it, there is no telling which sample would
// stand for a point.
constexpr float kFar = kOffPlane;
// Points between fetching and reading: enough to cover a cache miss.
constexpr std::size_t kAhead = 16;

float largest(const std::vector<float>& radii) {
  return radii.empty() ? 1.0F : *std::max_element(radii.begin(), radii.end());
}

}  // namespace

SenderSearch::SenderSearch(const Scene& scene, const SampleSet& samples)
    : scene_(&scene),
      samples_(&samples),
      reach_(largest(samples.radii)),
      grid_(samples.positions, samples.normals, kCell * reach_),
      surfaces_(scene, samples, grid_, kFar * reach_, reach_) {}

std::uint32_t SenderSearch::nearest(const SurfacePoint& point, float radius) const {
  const auto known = surfaces_.nearest(point, radius);
  return known ? *known : grid_.nearest(point.position, point.normal, radius);
}

bool SenderSearch::is_far(std::uint32_t sample, const SurfacePoint& point) const {
  const Vec3f offset = samples_->positions[sample] - point.position;
  const float limit = kFar * reach_;
  return squared_distance_off(offset, point.normal) > limit * limit;
}

std::uint32_t SenderSearch::find(const SurfacePoint& point) const {
  const auto near = nearest(point, kFar * reach_);
  if (near != kNone && !is_far(near, point)) return near;
  const auto sample = grid_.nearest(point.position, point.normal, kFar * reach_, 0.0F);
  if (sample == kNone || is_far(sample, point)) return kNone;
  const bool same = scene_->triangles[samples_->triangles[sample]].surface ==
                    scene_->triangles[point.triangle].surface;
  return same ? sample : kNone;
}

void SenderSearch::find(std::span<const SurfacePoint> points,
                        std::span<std::uint32_t> found) const {
  assert(points.size() == found.size());
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n + 2 * kAhead; ++i) {
    if (i < n) surfaces_.fetch_place(points[i]);
    if (i >= kAhead && i - kAhead < n) surfaces_.fetch_list(points[i - kAhead]);
    if (i >= 2 * kAhead) found[i - 2 * kAhead] = find(points[i - 2 * kAhead]);
  }
}

std::uint32_t SenderSearch::find_near(const SurfacePoint& point) const {
  return nearest(point, kReach * reach_);
}

}  // namespace prt
