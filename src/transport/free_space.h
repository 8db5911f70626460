// Where lights may stand: one rule for training lights and test lights (design: what "error"
// means).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "domains/samples.h"
#include "scene/ray_caster.h"

namespace prt {

struct LightBox {
  Vec3f low, high;
};

/// The bounding box of points, at least a tenth of its diagonal wide along every axis: a flat scene
/// has room for lights above it.
LightBox light_box(std::span<const Vec3f> points);

/// A position is free when it lies in the samples' light_box, at least `clearance` (m) from
/// every surface, and sees at least one sample from that sample's front. Draws `count` of them
/// uniformly; position k depends on (stream, k) alone, so any range can be drawn by any task:
/// `first` is the number of the first. Throws UserError when a position cannot be found in 10,000
/// tries.
std::vector<Vec3f> free_positions(const Scene& scene, const RayCaster& caster,
                                  const SampleSet& samples, float clearance, std::uint64_t stream,
                                  std::size_t first, std::size_t count);

/// The clearance that `share` of the samples' diagonal asks for, m; in wide and flat scenes, where
/// no light would find room, that share of five times the shortest side.
float light_clearance(const SampleSet& samples, float share);

/// Diagonal of the samples' bounding box, m: clearances are given relative to it.
float samples_diagonal(const SampleSet& samples);

}  // namespace prt
