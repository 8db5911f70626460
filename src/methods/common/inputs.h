// What several tasks of a process read alike, decoded once.
#pragma once

#include <memory>
#include <string>

#include "methods/method.h"
#include "transport/cells.h"
#include "transport/sender_search.h"

namespace prt {

struct SharedSamples {
  explicit SharedSamples(SampleSet set)
      : samples(std::move(set)), cluster_of_sample(samples.cluster_of_sample()) {}
  SampleSet samples;
  std::vector<std::uint32_t> cluster_of_sample;
};

/// Input `i` decoded as samples.
std::shared_ptr<const SharedSamples> shared_samples(const TaskReader& reader, std::size_t i);

/// The neighbour search over the samples of input `i`. It takes a while to make and looks at no
/// areas, so points that have no areas yet and the samples made of them share it.
std::shared_ptr<const SenderSearch> shared_search(const TaskReader& reader, std::size_t i);

/// Area weights of a cluster's samples.
VectorF cluster_areas(const SampleSet& samples, std::uint32_t cluster);

/// Appends the points of one artifact of the stage "cells".
void append_cell_points(const Artifact& part, CellPoints& points);

/// "rays/0007"
std::string numbered(const std::string& stage, std::size_t i);

/// TaskSpec::place of what reads cluster c's rays.
std::string cluster_place(std::size_t c);

/// Throws Interrupted if the bake was asked to stop.
void check_stop(const TaskReader& reader);

}  // namespace prt
