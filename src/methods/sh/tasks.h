// The tasks of the method, by kind. Inputs are listed in the order each expects them.
//
// A sample's transfer is a row of order² numbers: irradiance (W/m²) under an environment is its dot
// product with the environment's coefficients (bases/spherical_harmonics.h), per colour channel.
#pragma once

#include "methods/method.h"

namespace prt::sh {

/// samples[, rays/c] → a cluster's transfer of direct light, n × order²: shadowed, or without rays
/// in the open (SH §6.2.6.1 and 2), and the clusters that its rays reach.
Artifact run_direct(const TaskSpec& task, const TaskReader& reader);

/// samples, albedo, rays/c, the last bounce (or direct) of the clusters "senders" → transfer of a
/// cluster by one bounce more, n × (channels · order²), channel after channel (SH §6.2.6.3).
Artifact run_bounce(const TaskSpec& task, const TaskReader& reader);

/// samples, sky_direct/c, sky_bounce*/c → factors of direct transfer and of the sum of all bounces.
Artifact run_transfer(const TaskSpec& task, const TaskReader& reader);

}  // namespace prt::sh
