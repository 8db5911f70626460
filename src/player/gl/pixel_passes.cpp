#include "player/gl/pixel_passes.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "player/colours.h"

namespace prt::gl {

SplatPass::SplatPass(const SampleSet& samples, const SampleBuffers& buffers)
    : SplatPass(SplatField(samples), samples, buffers) {}

SplatPass::SplatPass(const SplatField& field, const SampleSet& samples,
                     const SampleBuffers& buffers)
    : samples_(&buffers),
      kernels_(kernel_cells(samples, field)),
      plain_(plain_cells(samples, field)),
      widest_(kSplatReach * field.largest_radius()),
      fallback_(kSplatFallback * field.largest_radius()) {}

Program& SplatPass::program(bool weak) {
  auto& made = weak ? weak_program_ : program_;
  if (!made) made.emplace(make_program(weak ? "#define WEAK_KERNELS\n" : ""));
  return *made;
}

Program SplatPass::make_program(const std::string& defines) const {
  constexpr float kLog2E = std::numbers::log2e_v<float>;
  const std::string samples = fmt::format(
      "#define OFF_PLANE {:f}\n#define COMPATIBLE_COSINE {:f}\n", kOffPlane, kCompatibleCosine);
  Program made =
      Program::graphics({"screen.glsl"}, {"surface.glsl", "splats.glsl"}, samples + defines);
  made.use();
  made.set("inverse_cell", kernels_.inverse_cell());
  made.set("slot_mask", kernels_.slot_mask());
  made.set("plain_inverse_cell", plain_.inverse_cell());
  made.set("plain_slot_mask", plain_.slot_mask());
  made.set("widest", widest_);
  made.set("smallest", kSmallestSplat);
  made.set("fallback", fallback_);
  made.set("exponents", Eigen::Vector4f(-kLog2E / (2.0F * kSplatSigma * kSplatSigma),
                                        -kLog2E / (2.0F * kSplatSigmaAcross * kSplatSigmaAcross),
                                        1.0F / (kSplatReach * kSplatReach), 0.0F));
  return made;
}

void SplatPass::draw(const Canvas& surfaces, const Canvas& splats, bool weak) {
  splats.draw_into();
  program(weak).use();
  surfaces.read_image_at(0, 0);
  surfaces.read_image_at(1, 1);
  samples_->positions.read_at(2);
  samples_->normals.read_at(3);
  kernels_.read_at(4, 5);
  plain_.read_at(6, 7);
  screen_.draw();
}

ShadePass::ShadePass(std::size_t clusters, const SampleBuffers& samples) : samples_(&samples) {
  std::vector<Eigen::Vector4f> colours;
  for (std::uint32_t c = 0; c < clusters; ++c) {
    colours.emplace_back(cluster_colour(c).homogeneous());
  }
  cluster_colours_ = vec4_texels(colours);
}

Program& ShadePass::program(const LightTable& lights, int quads, Colours colours) {
  std::string defines = fmt::format("#define LIGHTS {}\n#define QUADS {}\n", lights.count(), quads);
  if (colours == Colours::kRadiance) defines += "#define RADIANCE\n";
  if (colours == Colours::kVisibility) defines += "#define SHOW_VISIBILITY\n";
  if (colours == Colours::kClusters) defines += "#define SHOW_CLUSTERS\n";
  defines += lights.defines();
  const auto known = programs_.find(defines);
  if (known != programs_.end()) return known->second;
  return programs_
      .emplace(defines, Program::graphics({"screen.glsl"},
                                          {"lights.glsl", "surface.glsl", "shade.glsl"}, defines))
      .first->second;
}

void ShadePass::draw(const ShadeInput& input, Colours colours, const Look& look,
                     const Canvas& picture) {
  picture.draw_into();
  Program& work = program(*input.lights, input.fields->stride / 4, colours);
  work.use();
  work.set("direct_share", look.show == Show::kIndirect ? 0.0F : 1.0F);
  work.set("indirect_share", look.show == Show::kDirect ? 0.0F : 1.0F);
  work.set("exposure", look.exposure);
  work.set("background", background_colour());
  work.set("unlit_colour", unlit_colour());
  work.set("eye", input.eye);
  input.lights->bind();
  input.surfaces->read_image_at(0, 2);
  input.surfaces->read_image_at(1, 3);
  for (GLuint k = 0; k < 3; ++k) input.splats->read_image_at(k, 4 + k);
  input.fields->buffer.read_at(7);
  samples_->normals.read_at(8);
  cluster_colours_.read_at(9);
  glEnable(GL_FRAMEBUFFER_SRGB);
  screen_.draw();
  glDisable(GL_FRAMEBUFFER_SRGB);
}

}  // namespace prt::gl
