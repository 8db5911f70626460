// What a scene does without: decisions that the planner takes from finished artifacts, and what it
// says of them.
#pragma once

#include <vector>

#include "methods/method.h"

namespace prt::lb {

/// From the artifacts of the stage "visibility", all of them finished: clusters that need no
/// depths, functions that their bases do without, light from outside.
std::vector<LeftOut> needless_visibility(const PlanInputs& inputs, std::size_t clusters);

/// From those of a stage of transfer: pairs of clusters that exchange next to nothing.
std::vector<LeftOut> needless_blocks(const PlanInputs& inputs, const std::string& stage,
                                     std::size_t clusters);

/// From "light_functions": functions of direct light that too little hangs on.
std::vector<LeftOut> needless_light_functions(const Artifact& functions);

/// A share of the effect of direct light that functions may leave out together; most of the error
/// comes from those that lb.light_rank has no room for.
double light_tolerance(const OptionValues& options);

/// Fewest bounces after which at most `tolerance` of the indirect light is missing where no albedo
/// is above `largest`: every bounce more is at most so many times the one before, so all that come
/// after the first N are at most largest^N of the whole.
int sufficient_bounces(double largest, double tolerance);

}  // namespace prt::lb
