// The samples as shaders read them. Internal to player/gl.
#pragma once

#include "domains/samples.h"
#include "player/gl/objects.h"

namespace prt::gl {

/// Invocations of a work group; each group works within one cluster.
inline constexpr unsigned kGroup = 64;

struct SampleBuffers {
  explicit SampleBuffers(const SampleSet& samples);

  std::size_t count;
  TexelBuffer positions;  ///< xyz, one over the splat's radius; one more entry than samples
  TexelBuffer normals;    ///< xyz, cluster; the last has no normal, so that no splat is made of it
  TexelBuffer tangents;
  TexelBuffer groups;  ///< first sample, end, cluster
  std::size_t group_count = 0;
};

}  // namespace prt::gl
