// prt_inspect --image depth.
#pragma once

#include "apps/inspect/bake_reader.h"
#include "apps/inspect/drawing.h"

namespace prt {

/// A sample's hemispherical depth buffer, its reconstruction from the visibility basis, and their
/// difference: above unfolded on the grid of directions, below as a disk seen along the normal,
/// with labelled scales. Throws UserError if there is no such cluster or sample, UnsoundData if the
/// artifacts do not fit together.
Drawing draw_depth(const BakeReader& bake, int cluster, int index);

}  // namespace prt
