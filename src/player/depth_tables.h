// Depth buffers laid out for speed: the depths of any direction at a sample are one dot product of
// two contiguous rows. Internal to player/.
#pragma once

#include <variant>
#include <vector>

#include "package/package.h"
#include "scene/light.h"

namespace prt {

class DepthTables {
  struct Cluster;

 public:
  /// Lays out a package's depth buffers; both must outlive the tables.
  DepthTables(const DepthVisibility& visibility, const SampleSet& samples);

  /// What one sample sees. Good until the next one is asked for on the same thread.
  class View {
   public:
    /// Share of light in [0, 1] that comes from unit direction `to_light` (world) and `distance`
    /// (m, kInfinity from outside the scene).
    [[nodiscard]] float visibility(const Vec3f& to_light, float distance) const;

   private:
    friend class DepthTables;
    const DepthTables* tables_ = nullptr;
    const Cluster* cluster_ = nullptr;
    Mat3f to_local_;
    Vec3f position_;
    const float* weights_ = nullptr;  ///< of the basis' numbers: coefficients times their scales
  };
  /// `cluster` is the sample's own.
  [[nodiscard]] View at(std::uint32_t sample, std::uint32_t cluster) const;

 private:
  /// The basis' numbers as they are stored, directions × stride: rows are padded with zeros to
  /// whole vectors.
  using Numbers =
      std::variant<std::vector<std::int8_t>, std::vector<std::int16_t>, std::vector<float>>;
  struct Cluster {
    const DepthBlock* block = nullptr;
    bool only_walls = false;  ///< nothing but walls is in the way
    std::size_t stride = 0;
    Numbers basis;
    std::vector<float> mean;    ///< directions
    std::vector<float> scales;  ///< stride: of the basis' functions
  };
  static Cluster lay_out(const DepthBlock& block, std::size_t directions);

  const SampleSet* samples_;
  HemisphereDirections directions_;
  float bound_;
  float bias_;
  std::vector<Cluster> clusters_;
};

}  // namespace prt
