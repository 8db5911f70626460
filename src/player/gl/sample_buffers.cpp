#include "player/gl/sample_buffers.h"

#include "domains/splats.h"

namespace prt::gl {

SampleBuffers::SampleBuffers(const SampleSet& samples) : count(samples.size()) {
  const SplatField field(samples);
  const std::vector<std::uint32_t> cluster = samples.cluster_of_sample();
  std::vector<Eigen::Vector4f> position;
  std::vector<Eigen::Vector4f> normal;
  std::vector<Eigen::Vector4f> tangent;
  for (std::size_t i = 0; i < count; ++i) {
    position.emplace_back(samples.positions[i].homogeneous());
    position.back().w() = 1.0F / field.radius(static_cast<std::uint32_t>(i));
    normal.emplace_back(samples.normals[i].homogeneous());
    normal.back().w() = static_cast<float>(cluster[i]);
    tangent.emplace_back(samples.tangents[i].homogeneous());
  }
  position.emplace_back(0, 0, 0, 1);
  normal.emplace_back(0, 0, 0, 0);
  positions = vec4_texels(position);
  normals = vec4_texels(normal);
  tangents = vec4_texels(tangent);
  std::vector<std::uint32_t> group;
  for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
    for (std::uint32_t i = samples.cluster_begin[c]; i < samples.cluster_begin[c + 1];
         i += kGroup) {
      group.insert(group.end(), {i, samples.cluster_begin[c + 1], c, 0});
      ++group_count;
    }
  }
  groups = texels(GL_RGBA32UI, 16, group);
}

}  // namespace prt::gl
