// prt_inspect --image basis.
#pragma once

#include <optional>

#include "apps/inspect/bake_reader.h"
#include "apps/inspect/drawing.h"

namespace prt {

/// A cluster's light functions on its samples, seen along its mean normal: red positive, blue
/// negative, white zero, full colour at each function's largest value (Leonhardt & Bohn, figure 3).
/// All of them in a grid by order, or function `index` alone. Throws UserError if there is no such
/// cluster or function, UnsoundData if the artifacts do not fit together.
Drawing draw_basis(const BakeReader& bake, int cluster, std::optional<int> index);

}  // namespace prt
