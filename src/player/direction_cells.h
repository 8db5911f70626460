// Between which directions of a depth buffer a light stands, for many lights at once:
// HemisphereDirections::lookup on eight of them side by side. Internal to player/.
#pragma once

#include <cstdint>
#include <vector>

#include "domains/directions.h"

namespace prt {

/// Directions in a sample's frame, one per entry of x, y and z, and the cells that they lie in.
struct DirectionCells {
  std::vector<float> x, y, z;  ///< unit
  /// Direction at the cell's lower corner, and how far on the place is towards the next of its row
  /// and of its column, in [0, 1].
  std::vector<std::int32_t> corner;
  std::vector<float> across, along;

  /// For `count` entries at least, in whole vectors. What fills the last one up is anything finite.
  void make_room(std::size_t count);
};

/// Sets corner, across and along of the first `count` entries, of which z > 0. They are those of
/// HemisphereDirections::lookup but for rounding.
void find_cells(const HemisphereDirections& directions, std::size_t count, DirectionCells& cells);

}  // namespace prt
