// prt_inspect --image sky and environment.
#pragma once

#include <optional>
#include <string>

#include "apps/inspect/bake_reader.h"
#include "apps/inspect/drawing.h"

namespace prt {

/// Transfer of the sky's light to the samples, a panel for each spherical harmonic, a row for each
/// band: red positive, blue negative, white zero, full colour at the largest value of all. Or of
/// function `index` alone. Throws UserError if the bake has no such stage or function, UnsoundData
/// if the artifacts do not fit together.
Drawing draw_sky_transfer(const BakeReader& bake, std::optional<int> index);

/// An environment (scene/environment.h) as it is, as spherical harmonics of the bake's order have
/// it, and the share of each band in their energy. Throws UserError if there is no such environment
/// or the bake has no environment layer.
Drawing draw_environment(const BakeReader& bake, const std::string& spec);

}  // namespace prt
