#include "domains/surface_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

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
// coordinates, and of distances, relative to the reach.
constexpr float kSlack = 0x1p-18F;

/// Edges of a triangle from its vertex 0.
std::pair<Vec3f, Vec3f> edges(const Scene& scene, std::uint32_t t) {
  const auto& vertex = scene.triangles[t].vertex;
  const Vec3f& origin = scene.positions[vertex[0]];
  return {scene.positions[vertex[1]] - origin, scene.positions[vertex[2]] - origin};
}

/// Leaves out samples that another one beats at all corners of a texel with that normal, and so
/// everywhere between, by more than rounding: the difference of two squared distances is linear in
/// the point. `margin` in m².
void drop_beaten(const std::vector<Vec3f>& positions, const Vec3f& normal,
                 const std::array<Vec3f, 4>& corners, float margin,
                 std::vector<std::uint32_t>& near) {
  // By corner: comparing one sample with all others is a loop without a branch.
  std::array<std::array<float, kLongestList>, 4> squared;
  const std::size_t count = near.size();
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t k = 0; k < count; ++k) {
      squared[c][k] = squared_distance_off(positions[near[k]] - corners[c], normal);
    }
  }
  std::size_t kept = 0;
  for (std::size_t s = 0; s < count; ++s) {
    std::array<float, 4> least;
    for (std::size_t c = 0; c < 4; ++c) least[c] = squared[c][s] - margin;
    unsigned beaten = 0;
    for (std::size_t t = 0; t < count; ++t) {
      beaten |= static_cast<unsigned>(squared[0][t] < least[0]) &
                static_cast<unsigned>(squared[1][t] < least[1]) &
                static_cast<unsigned>(squared[2][t] < least[2]) &
                static_cast<unsigned>(squared[3][t] < least[3]);
    }
    if (beaten == 0) near[kept++] = near[s];
  }
  near.resize(kept);
}

std::uint16_t texels_along(float length, float texel) {
  return static_cast<std::uint16_t>(std::clamp(std::ceil(length / texel), 1.0F, kMostTexelsAcross));
}

}  // namespace

SurfaceGrid::SurfaceGrid(const Scene& scene, const SampleSet& samples, const SampleGrid& grid,
                         float reach, float texel)
    : scene_(&scene), positions_(&samples.positions), grid_(&grid), reach_(reach), texel_(texel) {
  size_patches(scene, samples.size());
  blocks_ = std::make_unique<std::atomic<const Entry*>[]>(blocks());
  begin_ = std::make_unique_for_overwrite<std::uint16_t[]>((kBlockTexels + 1) * blocks());
}

SurfaceGrid::~SurfaceGrid() {
  for (std::size_t b = 0; b < blocks(); ++b) delete[] blocks_[b].load();
}

std::size_t SurfaceGrid::made_texels() const {
  std::size_t made = 0;
  for (std::size_t b = 0; b < blocks(); ++b) {
    if (blocks_[b].load() != nullptr) made += std::min(kBlockTexels, texels_ - b * kBlockTexels);
  }
  return made;
}

void SurfaceGrid::size_patches(const Scene& scene, std::size_t samples) {
  const std::size_t most = kTexelsPerSample * samples + kTexelsPerTriangle * scene.triangles.size();
  patches_.resize(scene.triangles.size());
  for (float texel = texel_;; texel *= 2.0F) {
    std::size_t texels = 0;
    for (std::uint32_t t = 0; t < patches_.size(); ++t) {
      const auto [along_u, along_v] = edges(scene, t);
      patches_[t] = {static_cast<std::uint32_t>(texels), texels_along(along_u.norm(), texel),
                     texels_along(along_v.norm(), texel)};
      texels += std::size_t{2} * patches_[t].columns * patches_[t].rows;
      if (texels > most) break;
    }
    if (texels > most) continue;
    texels_ = texels;
    return;
  }
}

const SurfaceGrid::Entry* SurfaceGrid::make_block(std::size_t block) const {
  static_assert(kBlockTexels * kLongestList <= std::numeric_limits<std::uint16_t>::max());
  const std::lock_guard lock(making_[block % making_.size()]);
  if (const Entry* made = blocks_[block].load(std::memory_order_acquire)) return made;
  const std::size_t first = block * kBlockTexels;
  const std::size_t end = std::min(first + kBlockTexels, texels_);
  const auto after =
      std::upper_bound(patches_.begin(), patches_.end(), first,
                       [](std::size_t texel, const Patch& p) { return texel < p.first; });
  auto triangle = static_cast<std::uint32_t>(after - patches_.begin() - 1);
  std::vector<std::uint32_t> near;
  std::vector<Entry> listed;
  std::uint16_t* begin = begin_.get() + place_of(first);
  *begin = 0;
  for (std::size_t texel = first; texel < end; ++texel) {
    while (triangle + 1 < patches_.size() && patches_[triangle + 1].first <= texel) ++triangle;
    list_samples(triangle, texel - patches_[triangle].first, near, listed);
    *++begin = static_cast<std::uint16_t>(listed.size());
  }
  auto made = std::make_unique_for_overwrite<Entry[]>(listed.size());
  std::ranges::copy(listed, made.get());
  blocks_[block].store(made.get(), std::memory_order_release);
  return made.release();
}

/// Adds the list of a triangle's texel of that number.
void SurfaceGrid::list_samples(std::uint32_t triangle, std::size_t local,
                               std::vector<std::uint32_t>& near, std::vector<Entry>& listed) const {
  const Patch& patch = patches_[triangle];
  const auto [along_u, along_v] = edges(*scene_, triangle);
  const Vec3f step_u = along_u / patch.columns;
  const Vec3f step_v = along_v / patch.rows;
  const Vec3f& origin = scene_->positions[scene_->triangles[triangle].vertex[0]];
  const float slack =
      kSlack * (origin.cwiseAbs().maxCoeff() + along_u.norm() + along_v.norm() + reach_);
  const float half = 0.5F * std::max((step_u + step_v).norm(), (step_u - step_v).norm()) + slack;
  if (half > reach_) return;  // wider than the reach: left to the grid
  const std::size_t of_side = std::size_t{patch.columns} * patch.rows;
  const float side = local < of_side ? 1.0F : -1.0F;
  const std::size_t on_side = local % of_side;
  const Vec3f normal = side * triangle_normal(*scene_, triangle);
  const float u = static_cast<float>(on_side % patch.columns) + 0.5F;
  const std::size_t row = on_side / patch.columns;
  const float v = static_cast<float>(row) + 0.5F;
  const Vec3f middle = origin + u * step_u + v * step_v;
  // Farther samples are rare, and left to the grid.
  const float look = std::min(reach_, kLook * texel_) + half;
  const std::vector<Vec3f>& positions = *positions_;
  const auto squared = [&](std::uint32_t s) { return (positions[s] - middle).squaredNorm(); };
  near.clear();
  grid_->within(middle, normal, look, near);
  if (near.empty()) return;
  float least = kInfinity;
  for (const std::uint32_t s : near) {
    least = std::min(least, squared_distance_off(positions[s] - middle, normal));
  }
  // Nothing farther than this can be nearest anywhere in the texel.
  const float limit = std::min(std::sqrt(least) + 2.0F * half, reach_ + half);
  if (limit > look) {
    near.clear();
    grid_->within(middle, normal, limit, near);
  } else {
    std::erase_if(near, [&](std::uint32_t s) { return squared(s) > limit * limit; });
  }
  if (near.size() > kLongestList) return;
  const Vec3f to_corner = 0.5F * (step_u + step_v);
  const Vec3f to_next = 0.5F * (step_u - step_v);
  // Two samples of the list are at most twice the limit apart, and count as kOffPlane times as far.
  drop_beaten(positions, normal,
              {Vec3f(middle + to_corner), Vec3f(middle - to_corner), Vec3f(middle + to_next),
               Vec3f(middle - to_next)},
              4.0F * kOffPlane * kOffPlane * slack * limit, near);
  std::sort(near.begin(), near.end());  // ties go to the lowest
  for (const std::uint32_t s : near) listed.push_back({positions[s], s});
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
  const Entry* listed = lists_at(texel);
  const std::uint16_t* place = begin_.get() + place_of(texel);
  const std::span<const Entry> list(listed + place[0], listed + place[1]);
  if (list.empty()) return std::nullopt;
  float best = kInfinity;
  const Entry* nearest = nullptr;
  for (const Entry& entry : list) {
    const float d = squared_distance_off(entry.position - point.position, point.normal);
    if (d < best) {
      best = d;
      nearest = &entry;
    }
  }
  // Beyond the radius, samples that this one beats may be within.
  const Vec3f offset = nearest->position - point.position;
  if (offset.squaredNorm() > radius * radius) return std::nullopt;
  return nearest->sample;
}

}  // namespace prt
