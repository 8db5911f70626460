// What test lights told about a package, between the tasks that ask and the one that pools.
#pragma once

#include <span>
#include <vector>

#include "evaluate/compare.h"
#include "store/artifact.h"

namespace prt {

/// Adds arrays with one row per light: "light_position" (lights × 3, m), "sums" (lights × 5 × 7),
/// "direct_by_cluster" and "indirect_by_cluster" (lights × clusters × 7), "visibility" (lights × 6)
/// and "unreached" (lights). All lights have as many clusters.
void put_light_errors(Artifact& out, std::span<const LightErrors> lights);

/// Throws UnsoundData if arrays are missing or do not fit together.
std::vector<LightErrors> get_light_errors(const Artifact& in);

}  // namespace prt
