// What several tasks of a process read alike, decoded once.
#pragma once

#include <memory>
#include <string>

#include "methods/method.h"
#include "transport/cells.h"
#include "transport/sender_search.h"

namespace prt {

/// Samples with their neighbour search.
struct SharedSamples {
  SharedSamples(const Scene& scene, SampleSet set)
      : samples(std::move(set)),
        search(scene, samples),
        cluster_of_sample(samples.cluster_of_sample()) {}
  SampleSet samples;
  SenderSearch search;
  std::vector<std::uint32_t> cluster_of_sample;
};

/// Input `i` decoded as samples.
std::shared_ptr<const SharedSamples> shared_samples(const TaskReader& reader, std::size_t i);

/// Area weights of a cluster's samples.
VectorF cluster_areas(const SampleSet& samples, std::uint32_t cluster);

/// Appends the points of one artifact of the stage "cells".
void append_cell_points(const Artifact& part, CellPoints& points);

/// "rays/0007"
std::string numbered(const std::string& stage, std::size_t i);

/// Throws Interrupted if the bake was asked to stop.
void check_stop(const TaskReader& reader);

}  // namespace prt
