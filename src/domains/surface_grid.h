// Nearest samples by the texels of triangles: where a point is known to lie on a triangle, the
// samples that can be nearest there are known beforehand.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "domains/samples.h"
#include "scene/scene.h"

namespace prt {

/// Every side of every triangle is cut into texels, parallelograms in its barycentric coordinates;
/// each lists the samples that are nearest to some point of it, among those with a compatible
/// normal. Answers are those of SampleGrid::nearest, in less than half the time (results/rays.md).
/// Lists are made when first asked for, a few texels at once: whoever casts rays in one part of a
/// scene makes those that they hit. Thread-safe.
class SurfaceGrid {
 public:
  /// All must outlive it. `grid` holds the samples. `reach` (m): as far as answers are asked for;
  /// `texel` (m): about the distance between samples.
  SurfaceGrid(const Scene& scene, const SampleSet& samples, const SampleGrid& grid, float reach,
              float texel);
  ~SurfaceGrid();
  SurfaceGrid(const SurfaceGrid&) = delete;
  SurfaceGrid& operator=(const SurfaceGrid&) = delete;

  /// The nearest sample with a compatible normal within `radius` <= reach of a surface point, or
  /// kNone; nothing where the table does not know: then ask the grid.
  [[nodiscard]] std::optional<std::uint32_t> nearest(const SurfacePoint& point, float radius) const;

  /// Fetches what nearest() will read for a point into the caches: the place of its list some
  /// points ahead, then the list. The table is larger than they are, and points jump about in it.
  void fetch_place(const SurfacePoint& point) const {
    const std::size_t texel = texel_of(point);
    __builtin_prefetch(blocks_.get() + texel / kBlockTexels);
    __builtin_prefetch(begin_.get() + place_of(texel));
  }
  void fetch_list(const SurfacePoint& point) const {
    const std::size_t texel = texel_of(point);
    const Entry* listed = lists_at(texel);  // made by now: so is where they begin
    __builtin_prefetch(listed + begin_[place_of(texel)]);
  }

  /// Texels, and those whose lists have been made.
  [[nodiscard]] std::size_t texels() const { return texels_; }
  [[nodiscard]] std::size_t made_texels() const;

 private:
  struct Patch {
    std::uint32_t first = 0;  ///< texel of the front side at barycentric (0, 0)
    std::uint16_t columns = 1;
    std::uint16_t rows = 1;
  };
  struct Entry {
    Vec3f position;
    std::uint32_t sample;
  };
  /// Lists of so many texels that follow each other are made at once: few enough that hardly any is
  /// made in vain, and enough that a look at which are made stays in the caches.
  static constexpr std::size_t kBlockTexels = 32;

  [[nodiscard]] std::size_t texel_of(const SurfacePoint& point) const;
  /// Of a texel in begin_: each block has one more, its end.
  static std::size_t place_of(std::size_t texel) { return texel + texel / kBlockTexels; }
  /// The lists of the texel's block.
  [[nodiscard]] const Entry* lists_at(std::size_t texel) const {
    const std::size_t block = texel / kBlockTexels;
    const Entry* made = blocks_[block].load(std::memory_order_acquire);
    return made != nullptr ? made : make_block(block);
  }
  [[nodiscard]] std::size_t blocks() const { return (texels_ + kBlockTexels - 1) / kBlockTexels; }
  void size_patches(const Scene& scene, std::size_t samples);
  const Entry* make_block(std::size_t block) const;
  void list_samples(std::uint32_t triangle, std::size_t local, std::vector<std::uint32_t>& near,
                    std::vector<Entry>& listed) const;

  const Scene* scene_;
  const std::vector<Vec3f>* positions_;
  const SampleGrid* grid_;
  float reach_;
  float texel_;
  std::vector<Patch> patches_;  // per triangle: front texels, then as many of the back
  std::size_t texels_ = 0;
  // Made or null; its entries of begin_ are written before. Positions beside the numbers of
  // samples: one cache miss less per answer.
  std::unique_ptr<std::atomic<const Entry*>[]> blocks_;
  std::unique_ptr<std::uint16_t[]> begin_;     // in its block; an empty list: ask the grid
  mutable std::array<std::mutex, 64> making_;  // by block
};

}  // namespace prt
