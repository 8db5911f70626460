// The package's operators as compute passes. Internal to player/gl.
#pragma once

#include "operators/blocks.h"
#include "player/gl/quad_rows.h"
#include "player/gl/sample_buffers.h"

namespace prt::gl {

/// A value at the samples, in three parts: so many times the direct light, what came straight from
/// the environment, and the rest (vec4 each; nullptr: none).
struct SampleValue {
  float direct_share = 0.0F;
  const TexelBuffer* sky = nullptr;
  const TexelBuffer* rest = nullptr;
};

/// Texels of a buffer with a value for each sample: reading a padded row goes past the last one.
inline std::size_t sample_texels(std::size_t samples) { return samples + 4; }

/// Where coefficients stand: channel after channel, each cluster's padded to whole texels.
class CoefficientLayout {
 public:
  explicit CoefficientLayout(const ClusterProjection& projection);
  /// `begin`: first coefficient of each cluster, and their number.
  explicit CoefficientLayout(const std::vector<std::uint32_t>& begin);
  [[nodiscard]] std::uint32_t quad(std::size_t cluster) const { return quad_begin_[cluster]; }
  [[nodiscard]] std::uint32_t functions(std::size_t cluster) const { return functions_[cluster]; }
  [[nodiscard]] std::uint32_t channel_quads() const { return quad_begin_.back(); }

 private:
  std::vector<std::uint32_t> quad_begin_;
  std::vector<std::uint32_t> functions_;
};

/// Irradiance (one part) to coefficients.
class ProjectionPass {
 public:
  ProjectionPass(const ClusterProjection& projection, const SampleSet& samples);
  void run(const TexelBuffer& irradiance, const TexelBuffer& coefficients);
  [[nodiscard]] const CoefficientLayout& layout() const { return layout_; }

 private:
  CoefficientLayout layout_;
  int rows_count_ = 0;
  TexelBuffer rows_, blocks_, scales_, places_, partial_;
  Program parts_, sum_;
};

/// Coefficients to irradiance.
class TransferPass {
 public:
  TransferPass(const ClusterTransfer& transfer, const CoefficientLayout& layout,
               const SampleSet& samples, const SampleBuffers& buffers);
  void run(const TexelBuffer& coefficients, const TexelBuffer& irradiance);

 private:
  const SampleBuffers* buffers_;
  std::uint32_t channel_quads_;  // of coefficients
  int coloured_;
  int rows_count_ = 0;
  std::uint32_t reduced_quads_ = 0;  // of a channel
  TexelBuffer rows_, columns_, right_, right_scales_, receivers_, left_, left_scales_, reduced_;
  Program to_reduced_, to_samples_;
};

/// Irradiance (without a part of the environment) to irradiance.
class NearPass {
 public:
  explicit NearPass(const NearTransfer& near);
  void run(const SampleValue& value, const TexelBuffer& direct, const TexelBuffer& received);

 private:
  int count_;
  TexelBuffer receivers_, senders_, albedo_, exitant_;
  Program reflect_, gather_;
};

/// a_share · a + b_share · b, texel by texel.
class CombinePass {
 public:
  CombinePass() : program_(Program::compute({"combine.glsl"})) {}
  void run(float a_share, const TexelBuffer& a, float b_share, const TexelBuffer& b,
           const TexelBuffer& sum);

 private:
  Program program_;
};

}  // namespace prt::gl
