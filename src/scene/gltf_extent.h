// Where the geometry of a glTF file lies, in double, before anything is rounded to float. Internal
// to scene/.
#pragma once

#include <limits>
#include <vector>

#include "base/types.h"
#include "scene/gltf_nodes.h"

namespace prt::gltf {

struct Extent {
  /// Bounding box of all triangles with finite corners, m; empty (low > high) where there is none.
  Vec3d low = Vec3d::Constant(std::numeric_limits<double>::infinity());
  Vec3d high = -low;
  /// Half the spacing of the file's own float coordinates where it is widest, m in the world: what
  /// a vertex may be off before the loader sees it.
  double vertex_rounding = 0.0;
  /// How far from the origin of their mesh the farthest of those vertices lie, m in the world.
  double vertex_distance = 0.0;

  [[nodiscard]] bool empty() const { return !(low.array() <= high.array()).all(); }
  [[nodiscard]] Vec3d centre() const { return 0.5 * (low + high); }
  [[nodiscard]] double diagonal() const { return empty() ? 0.0 : (high - low).norm(); }
};

/// Throws UserError: more triangles than memory bears, a vertex beyond kFarthestCoordinate.
Extent measure_extent(const Document& document, const std::vector<WorldNode>& nodes);

/// Scene::origin for geometry of that extent. Zero unless the centre lies more than 16 diagonals
/// from the world's origin, where float coordinates have lost four bits and more; then the centre
/// rounded to a power of two of between 2 and 4 diagonals. Every position is then within three
/// diagonals of it, and a scene that is moved by a multiple of that power keeps its coordinates bit
/// for bit.
Vec3d choose_origin(const Extent& extent);

}  // namespace prt::gltf
