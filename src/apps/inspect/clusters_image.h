// prt_inspect --image clusters, rank, error: the scene in colours by cluster.
#pragma once

#include <cstdint>
#include <span>

#include "apps/inspect/cluster_values.h"
#include "apps/inspect/drawing.h"
#include "domains/samples.h"

namespace prt {

/// Samples as disks coloured by cluster, roots as white dots (Leonhardt & Bohn, figure 1), seen
/// from outside with back faces left out, so that one looks into a room through its near walls. The
/// side is the one that shows most surface. Throws UserError if there is no sample or one is not
/// finite.
Drawing draw_clusters(const SampleSet& samples, std::span<const std::uint32_t> roots,
                      int width = 1280, int height = 960);

/// The same view with clusters coloured by a value, from dark (low) to light (high); grey where it
/// is not known. Throws as above, UnsoundData if there is not one value for each cluster.
Drawing draw_values(const SampleSet& samples, const ClusterValues& values, int width = 1280,
                    int height = 960);
/// What the colours mean, bottom left.
void draw_legend(Drawing& drawing, const ClusterValues& values);

}  // namespace prt
