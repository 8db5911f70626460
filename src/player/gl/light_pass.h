// Direct light at the samples: the program's DirectLight step. Internal to player/gl.
#pragma once

#include <map>
#include <string>

#include "package/package.h"
#include "player/gl/light_table.h"
#include "player/gl/sample_buffers.h"

namespace prt::gl {

/// What pixels read of a sample, in floats: indirect irradiance, then the visibility of each light.
struct SampleFields {
  SampleFields(std::size_t samples, int lights)
      : stride(stride_for(lights)),
        buffer(GL_RGBA32F, 16, samples * static_cast<std::size_t>(stride) / 4) {}
  static int stride_for(int lights) { return (3 + lights + 3) / 4 * 4; }
  int stride;
  TexelBuffer buffer;
};

class LightPass {
 public:
  /// Depth buffers stay quantised. Both must outlive the pass.
  LightPass(const Package& package, const SampleBuffers& samples);

  /// Irradiance of all lights at the samples (vec4) and their visibilities.
  void run(const LightTable& lights, const TexelBuffer& irradiance, const SampleFields& fields);

 private:
  void upload(const DepthVisibility& visibility, const SampleSet& samples);
  Program& program(const std::string& light_defines);
  void bind() const;

  const SampleBuffers* samples_;
  std::string defines_;  // of the tables' types
  std::map<std::string, Program> programs_;
  bool shadows_ = false;
  int grid_width_ = 1, grid_height_ = 1;
  float bound_ = 1.0F, bias_ = 0.0F;
  TexelBuffer clusters_, coefficients_, coefficient_scales_, basis_, basis_scales_, means_, walls_;
};

}  // namespace prt::gl
