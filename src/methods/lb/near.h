// Near transfer: light between samples that fill much of each other's hemisphere, entry by entry.
#pragma once

#include "methods/lb/scene_part.h"
#include "methods/method.h"
#include "operators/blocks.h"
#include "transport/gather.h"

namespace prt::lb {

/// Near light goes to and fro so many times; what comes after is left to the light functions.
inline constexpr int kNearBounces = 3;

/// Appends the entries of one cluster's artifact of the stage "near": clusters in order.
void append_near(const Artifact& part, NearTransfer& near);

/// The entries between a part's samples, with the shares that the package has; inputs first,
/// first + 1, ... are those of its clusters.
std::shared_ptr<const GatherEntries> shared_near(const TaskReader& reader, std::size_t first,
                                                 const ScenePart& part);

}  // namespace prt::lb
