#include "domains/surface_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace prt {

namespace {

// More texels than this per sample and triangle would fill memory where samples are few and
// surfaces wide; texels grow until they fit.
constexpr std::size_t kTexelsPerSample = 16;
constexpr std::size_t kTexelsPerTriangle = 4;
constexpr float kMostTexelsAcross = 4096.0F;
// Longer lists are no faster than the grid.
constexpr std::size_t kLongestList = 48;
// Samples within this many texels of a texel's middle make a list.
constexpr float kLook = 1.5F;
// Covers the rounding of a point's position and barycentric coordinates, relative to the triangle's
// coordinates.
constexpr float kSlack = 0x1p-18F;

/// Edges of a triangle from its vertex 0.
std::pair<Vec3f, Vec3f> edges(const Scene& scene, std::uint32_t t) {
  const auto& vertex = scene.triangles[t].vertex;
  const Vec3f& origin = scene.positions[vertex[0]];
  return {scene.positions[vertex[1]] - origin, scene.positions[vertex[2]] - origin};
}

/// Leaves out samples that another one beats at all corners of a texel with that normal, and so
/// everywhere between, by more than rounding: the difference of two squared distances is linear in
/// the point. `slack` in metres.
void drop_beaten(const std::vector<Vec3f>& positions, const Vec3f& normal,
                 const std::array<Vec3f, 4>& corners, float slack,
                 std::vector<std::uint32_t>& near) {
  const auto beats = [&](std::uint32_t t, std::uint32_t s) {
    // No gradient of that difference is longer.
    const float margin =
        2.0F * slack * kOffPlane * kOffPlane * (positions[t] - positions[s]).norm();
    return std::all_of(corners.begin(), corners.end(), [&](const Vec3f& p) {
      return squared_distance_off(positions[t] - p, normal) + margin <
             squared_distance_off(positions[s] - p, normal);
    });
  };
  std::vector<std::uint32_t> kept;
  for (const std::uint32_t s : near) {
    if (std::none_of(near.begin(), near.end(), [&](std::uint32_t t) { return beats(t, s); })) {
      kept.push_back(s);
    }
  }
  near.swap(kept);
}

std::uint16_t texels_along(float length, float texel) {
  return static_cast<std::uint16_t>(std::clamp(std::ceil(length / texel), 1.0F, kMostTexelsAcross));
}

}  // namespace

SurfaceGrid::SurfaceGrid(const Scene& scene, const SampleSet& samples, const SampleGrid& grid,
                         float reach, float texel) {
  size_patches(scene, samples.size(), texel);
  begin_ = {0};
  for (std::uint32_t t = 0; t < patches_.size(); ++t)
    list_samples(scene, samples.positions, grid, t, reach, texel);
}

void SurfaceGrid::size_patches(const Scene& scene, std::size_t samples, float texel) {
  const std::size_t most = kTexelsPerSample * samples + kTexelsPerTriangle * scene.triangles.size();
  patches_.resize(scene.triangles.size());
  for (;; texel *= 2.0F) {
    std::size_t texels = 0;
    for (std::uint32_t t = 0; t < patches_.size(); ++t) {
      const auto [along_u, along_v] = edges(scene, t);
      patches_[t] = {static_cast<std::uint32_t>(texels), texels_along(along_u.norm(), texel),
                     texels_along(along_v.norm(), texel)};
      texels += std::size_t{2} * patches_[t].columns * patches_[t].rows;
      if (texels > most) break;
    }
    if (texels <= most) return;
  }
}

void SurfaceGrid::list_samples(const Scene& scene, const std::vector<Vec3f>& positions,
                               const SampleGrid& grid, std::uint32_t triangle, float reach,
                               float texel) {
  const Patch& patch = patches_[triangle];
  const auto [along_u, along_v] = edges(scene, triangle);
  const Vec3f step_u = along_u / patch.columns;
  const Vec3f step_v = along_v / patch.rows;
  const Vec3f& origin = scene.positions[scene.triangles[triangle].vertex[0]];
  const float slack = kSlack * (origin.cwiseAbs().maxCoeff() + along_u.norm() + along_v.norm());
  const float half = 0.5F * std::max((step_u + step_v).norm(), (step_u - step_v).norm()) + slack;
  const Vec3f front = triangle_normal(scene, triangle);
  std::vector<std::uint32_t> near;
  for (const float side : {1.0F, -1.0F}) {
    const Vec3f normal = side * front;
    for (int row = 0; row < patch.rows; ++row) {
      for (int column = 0; column < patch.columns; ++column) {
        const float u = static_cast<float>(column) + 0.5F;
        const float v = static_cast<float>(row) + 0.5F;
        const Vec3f middle = origin + u * step_u + v * step_v;
        // Farther samples are rare, and left to the grid; so are texels wider than the reach.
        const float look = std::min(reach, kLook * texel) + half;
        const std::uint32_t nearest = half <= reach ? grid.nearest(middle, normal, look) : kNone;
        if (nearest != kNone) {
          // Nothing farther than this can be nearest anywhere in the texel.
          const float off = std::sqrt(squared_distance_off(positions[nearest] - middle, normal));
          const float limit = std::min(off + 2.0F * half, reach + half);
          near.clear();
          grid.within(middle, normal, limit, near);
          if (near.size() <= kLongestList) {
            const Vec3f to_corner = 0.5F * (step_u + step_v);
            const Vec3f to_next = 0.5F * (step_u - step_v);
            drop_beaten(positions, normal,
                        {Vec3f(middle + to_corner), Vec3f(middle - to_corner),
                         Vec3f(middle + to_next), Vec3f(middle - to_next)},
                        slack, near);
            std::sort(near.begin(), near.end());  // ties go to the lowest
            for (const std::uint32_t s : near) listed_.push_back({positions[s], s});
          }
        }
        begin_.push_back(static_cast<std::uint32_t>(listed_.size()));
      }
    }
  }
}

std::size_t SurfaceGrid::texel_of(const SurfacePoint& point) const {
  const Patch& patch = patches_[point.triangle];
  const int column = std::clamp(static_cast<int>(point.u * static_cast<float>(patch.columns)), 0,
                                patch.columns - 1);
  const int row =
      std::clamp(static_cast<int>(point.v * static_cast<float>(patch.rows)), 0, patch.rows - 1);
  const std::size_t back = point.front ? 0 : std::size_t{patch.columns} * patch.rows;
  return patch.first + back + static_cast<std::size_t>(row) * patch.columns +
         static_cast<std::size_t>(column);
}

std::optional<std::uint32_t> SurfaceGrid::nearest(const SurfacePoint& point, float radius) const {
  const std::size_t texel = texel_of(point);
  const std::uint32_t begin = begin_[texel];
  const std::uint32_t end = begin_[texel + 1];
  if (begin == end) return std::nullopt;
  float best = kInfinity;
  std::uint32_t found = begin;
  for (std::uint32_t k = begin; k < end; ++k) {
    const float d = squared_distance_off(listed_[k].position - point.position, point.normal);
    if (d < best) {
      best = d;
      found = k;
    }
  }
  // Beyond the radius, samples that this one beats may be within.
  const Entry& nearest = listed_[found];
  if ((nearest.position - point.position).squaredNorm() > radius * radius) return std::nullopt;
  return nearest.sample;
}

}  // namespace prt
