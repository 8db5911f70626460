// How fine a bake is, in steps: what an accuracy that is asked for is reached with.
#pragma once

#include "methods/options.h"

namespace prt::lb {

/// Steps there are: 0 is the coarsest.
int effort_levels();

/// `options` with the counts, ranks and tolerances of a level in the place of their own. From one
/// level to the next a bake costs 2 to 3 times as much.
OptionValues with_effort(OptionValues options, int level);

}  // namespace prt::lb
