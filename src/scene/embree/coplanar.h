// Which triangles lie on top of one another. Internal to scene/embree/.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace prt {

/// 1 for every triangle that covers a part of another one in the same plane (to rounding), so that
/// rays may hit both at the same distance; one element per triangle. Empty if there is none.
std::vector<std::uint8_t> contested_triangles(const Scene& scene);

}  // namespace prt
