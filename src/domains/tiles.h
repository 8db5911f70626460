// Space cut into boxes, so that thinning can go on in all of them at once.
#pragma once

#include <cstddef>
#include <vector>

#include "base/types.h"

namespace prt {

/// Boxes that fill space without overlap, each with about as many of some points; those at the rim
/// are without end.
class Tiles {
 public:
  /// Halves the points across the longest side of their box until there are `count` (>= 1) parts.
  Tiles(std::vector<Vec3f> points, std::size_t count);

  [[nodiscard]] std::size_t size() const { return boxes_.size(); }
  /// Each point lies in just one tile.
  [[nodiscard]] bool contains(std::size_t tile, const Vec3f& p) const;
  /// From p to the tile's box, m; 0 inside.
  [[nodiscard]] float distance(std::size_t tile, const Vec3f& p) const;

 private:
  struct Box {
    Vec3f low = Vec3f::Constant(-kInfinity);
    Vec3f high = Vec3f::Constant(kInfinity);
  };
  struct Part;
  void halve(const Part& part);
  std::vector<Box> boxes_;
};

}  // namespace prt
