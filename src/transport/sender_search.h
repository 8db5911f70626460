// Which sample stands for a surface point: one rule for gather, photons and cell areas.
#pragma once

#include <span>

#include "domains/samples.h"
#include "domains/surface_grid.h"
#include "scene/scene.h"

namespace prt {

/// Finds the sample whose cell a surface point lies in.
class SenderSearch {
 public:
  /// Both must outlive it.
  SenderSearch(const Scene& scene, const SampleSet& samples);

  /// The nearest sample with a compatible normal (squared_distance_off); where none is near, the
  /// nearest one within 90° if it is of the same glTF surface; else kNone: the light that goes
  /// there is lost and counted.
  [[nodiscard]] std::uint32_t find(const SurfacePoint& point) const;

  /// find() for each of many points: the waiting for memory overlaps.
  void find(std::span<const SurfacePoint> points, std::span<std::uint32_t> found) const;

  /// The nearest compatible sample within the largest Poisson-disk reach of the point, or kNone:
  /// the strict rule by which cells are measured.
  [[nodiscard]] std::uint32_t find_near(const SurfacePoint& point) const;

 private:
  [[nodiscard]] bool is_far(std::uint32_t sample, const SurfacePoint& point) const;
  [[nodiscard]] std::uint32_t nearest(const SurfacePoint& point, float radius) const;

  const Scene* scene_;
  const SampleSet* samples_;
  float reach_ = 0.0F;
  SampleGrid grid_;
  SurfaceGrid surfaces_;
};

}  // namespace prt
