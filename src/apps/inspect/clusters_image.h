// prt_inspect --image clusters.
#pragma once

#include <cstdint>
#include <span>

#include "apps/inspect/picture.h"
#include "domains/samples.h"

namespace prt {

/// Samples as disks coloured by cluster, roots as white dots (Leonhardt & Bohn, figure 1), seen
/// from outside with back faces left out, so that one looks into a room through its near walls. The
/// side is the one that shows most surface. Throws UserError if there is no sample or one is not
/// finite.
Picture draw_clusters(const SampleSet& samples, std::span<const std::uint32_t> roots,
                      int width = 1280, int height = 960);

}  // namespace prt
