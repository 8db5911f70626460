// Groups samples into clusters around root points and gives them frames (Leonhardt & Bohn, §4.1).
#pragma once

#include <cstdint>
#include <vector>

#include "domains/samples.h"

namespace prt {

/// Samples before they are sorted: parallel arrays.
struct LooseSamples {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<float> radii;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint64_t> priorities;
};

struct ClusteredSamples {
  SampleSet samples;                 ///< areas still empty
  std::vector<std::uint32_t> roots;  ///< per cluster the sample that is its root point
};

/// Root points are a Poisson-disk subset with a larger radius, chosen so that there are about
/// samples / cluster_size of them; each sample joins the nearest root whose normal is within 60° of
/// its own, distance in position and normal together. Within a cluster samples follow a
/// space-filling curve, so neighbours are near in memory. A sample's tangent is its root's, turned
/// by the smallest rotation from the root's normal to its own.
ClusteredSamples cluster_samples(const LooseSamples& loose, std::size_t cluster_size);

}  // namespace prt
