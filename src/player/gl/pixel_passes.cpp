#include "player/gl/pixel_passes.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "player/colours.h"
#include "player/view.h"

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

EnvironmentImage::EnvironmentImage(const Environment& environment)
    : texture_(new_texture()), turn_(static_cast<float>(environment.turn())) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  if (environment.width() > most || environment.height() > most) {
    throw UserError(
        fmt::format("--env: a picture of {} x {} is too large for this OpenGL, which "
                    "takes {}; make it smaller",
                    environment.width(), environment.height(), most));
  }
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGB32F, environment.width(), environment.height());
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, environment.width(), environment.height(), GL_RGB,
                  GL_FLOAT, environment.cells().front().data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void EnvironmentImage::read_at(GLuint texture_unit) const {
  bind_texture(texture_unit, GL_TEXTURE_2D, texture_.id());
}

Program& ShadePass::program(const ShadeInput& input, Colours colours) {
  const LightTable& lights = *input.lights;
  std::string defines = fmt::format("#define LIGHTS {}\n#define QUADS {}\n", lights.count(),
                                    input.fields->stride / 4);
  if (input.environment != nullptr) defines += "#define ENVIRONMENT\n";
  if (colours == Colours::kRadiance) defines += "#define RADIANCE\n";
  if (colours == Colours::kVisibility) defines += "#define SHOW_VISIBILITY\n";
  if (colours == Colours::kClusters) defines += "#define SHOW_CLUSTERS\n";
  defines += lights.defines();
  const auto known = programs_.find(defines);
  if (known != programs_.end()) return known->second;
  Program made =
      input.environment == nullptr
          ? Program::graphics({"screen.glsl"}, {"lights.glsl", "surface.glsl", "shade.glsl"},
                              defines)
          : Program::graphics({"screen.glsl"},
                              {"lights.glsl", "surface.glsl", "environment.glsl", "shade.glsl"},
                              defines);
  return programs_.emplace(defines, std::move(made)).first->second;
}

namespace {

void set_environment(const ShadeInput& input, const Look& look, const Canvas& picture,
                     Program& work) {
  const auto width = static_cast<float>(picture.width());
  const auto height = static_cast<float>(picture.height());
  const Mat3f axes = camera_axes(*input.camera).cast<float>();
  const float half = 1.0F / static_cast<float>(view_scale(*input.camera));
  work.set("view_right", Vec3f(half * width / height * axes.col(0)));
  work.set("view_up", Vec3f(half * axes.col(1)));
  work.set("view_back", Vec3f(axes.col(2)));
  work.set("picture_size", Eigen::Vector2f(width, height));
  work.set("turn", input.environment->turn() + look.turn * kPi / 180.0F);
  work.set("reflection", look.show == Show::kFull ? look.reflection : 0.0F);
  input.environment->read_at(10);
}

}  // namespace

void ShadePass::draw(const ShadeInput& input, Colours colours, const Look& look,
                     const Canvas& picture) {
  picture.draw_into();
  Program& work = program(input, colours);
  work.use();
  work.set("direct_share", look.show == Show::kIndirect ? 0.0F : 1.0F);
  work.set("exposure", look.exposure);
  work.set("background", background_colour());
  work.set("unlit_colour", unlit_colour());
  work.set("eye", input.camera->eye);
  if (input.environment != nullptr) set_environment(input, look, picture, work);
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
