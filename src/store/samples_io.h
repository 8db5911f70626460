// Samples as arrays of an artifact.
#pragma once

#include "domains/samples.h"
#include "store/artifact.h"

namespace prt {

/// Adds position, normal, tangent, radius, triangle, cluster_begin, and area where it is known.
void put_samples(Artifact& artifact, const SampleSet& samples);
/// Throws UnsoundData if arrays are missing or do not fit together.
SampleSet get_samples(const Artifact& artifact);

}  // namespace prt
