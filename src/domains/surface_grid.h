// Nearest samples by the texels of triangles: where a point is known to lie on a triangle, the
// samples that can be nearest there are known beforehand.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "domains/samples.h"
#include "scene/scene.h"

namespace prt {

/// Every side of every triangle is cut into texels, parallelograms in its barycentric coordinates;
/// each lists the samples that are nearest to some point of it, among those with a compatible
/// normal. Answers are those of SampleGrid::nearest, in less than half the
/// time (results/rays.md).
class SurfaceGrid {
 public:
  SurfaceGrid() = default;
  /// `grid` holds the samples; both may go away afterwards. `reach` (m): as far as answers are
  /// asked for; `texel` (m): about the distance between samples.
  SurfaceGrid(const Scene& scene, const SampleSet& samples, const SampleGrid& grid, float reach,
              float texel);

  /// The nearest sample with a compatible normal within `radius` <= reach of a surface point, or
  /// kNone; nothing where the table does not know: then ask the grid.
  [[nodiscard]] std::optional<std::uint32_t> nearest(const SurfacePoint& point, float radius) const;

  /// Fetches what nearest() will read for a point into the caches: the place of its list some
  /// points ahead, then the list. The table is larger than they are, and points jump about in it.
  void fetch_place(const SurfacePoint& point) const {
    __builtin_prefetch(begin_.data() + texel_of(point));
  }
  void fetch_list(const SurfacePoint& point) const {
    __builtin_prefetch(listed_.data() + begin_[texel_of(point)]);
  }

 private:
  struct Patch {
    std::uint32_t first = 0;  ///< texel of the front side at barycentric (0, 0)
    std::uint16_t columns = 1;
    std::uint16_t rows = 1;
  };
  [[nodiscard]] std::size_t texel_of(const SurfacePoint& point) const;
  void size_patches(const Scene& scene, std::size_t samples, float texel);
  void list_samples(const Scene& scene, const std::vector<Vec3f>& positions, const SampleGrid& grid,
                    std::uint32_t triangle, float reach, float texel);

  std::vector<Patch> patches_;        // per triangle: front texels, then as many of the back
  std::vector<std::uint32_t> begin_;  // texels + 1; an empty list: ask the grid
  struct Entry {
    Vec3f position;
    std::uint32_t sample;
  };
  std::vector<Entry> listed_;  // positions beside the numbers: one cache miss less per answer
};

}  // namespace prt
