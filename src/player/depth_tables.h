// Depth buffers laid out for speed: the depths of any direction at a sample are one dot product of
// two contiguous rows. Internal to player/.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "package/package.h"
#include "scene/light.h"

namespace prt {

class DepthTables {
 public:
  /// Decodes a package's depth buffers; `samples` must outlive the tables.
  DepthTables(const DepthVisibility& visibility, const SampleSet& samples);

  /// Share of light in [0, 1] that comes to a sample from unit direction `to_light` (world) and
  /// `distance` (m, kInfinity from outside the scene); cluster is the sample's own.
  [[nodiscard]] float visibility(std::uint32_t sample, std::uint32_t cluster, const Vec3f& to_light,
                                 float distance) const;

 private:
  using Floats = std::vector<float, Eigen::aligned_allocator<float>>;
  /// The mean is one more basis row, with coefficient 1; rows are padded with zeros to whole
  /// vectors.
  struct Cluster {
    bool only_walls = false;  ///< nothing but walls is in the way
    MatrixF walls;            ///< w × 4
    std::size_t stride = 0;
    Floats basis;         ///< directions × stride
    Floats coefficients;  ///< samples of the cluster × stride
  };
  static Cluster decode(const DepthBlock& block, std::size_t directions, std::size_t samples);

  const SampleSet* samples_;
  HemisphereDirections directions_;
  float bound_;
  float bias_;
  std::vector<Cluster> clusters_;
};

}  // namespace prt
