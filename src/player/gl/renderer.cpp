#include "player/gl/renderer.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "player/gl/geometry_pass.h"
#include "player/gl/pass_clock.h"
#include "player/gl/pixel_passes.h"
#include "player/tone.h"

namespace prt::gl {
namespace {

bool same_camera(const SceneCamera& a, const SceneCamera& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.vertical_fov == b.vertical_fov;
}

Colours colours_of(Show show) {
  if (show == Show::kClusters) return Colours::kClusters;
  return show == Show::kVisibility ? Colours::kVisibility : Colours::kDisplay;
}

/// Stops before anything is uploaded that cannot be played.
const Package& playable(const Package& package) {
  if (epoxy_gl_version() < 43) {
    throw UserError(
        fmt::format("--backend gl needs OpenGL 4.3 core, and this one is {}.{}; update "
                    "the driver or use --backend cpu",
                    epoxy_gl_version() / 10, epoxy_gl_version() % 10));
  }
  if (package.samples.size() > kMostSamples) {
    throw UserError(
        fmt::format("--backend gl plays up to {} samples, and this package has {}; use "
                    "--backend cpu",
                    kMostSamples, package.samples.size()));
  }
  return package;
}

}  // namespace

std::string renderer_name() {
  return fmt::format("{}, OpenGL {}", reinterpret_cast<const char*>(glGetString(GL_RENDERER)),
                     reinterpret_cast<const char*>(glGetString(GL_VERSION)));
}

struct GlView::Images {
  Images(int width, int height, int side)
      : surfaces(side * width, side * height, {kVec4Image, kIndex4Image}, true),
        splats(side * width, side * height, {kIndex4Image, kIndex4Image, kIndex4Image}, false),
        picture(width, height, {kSrgbImage}, false) {
    if (side > 1)
      samples.emplace(side * width, side * height, std::initializer_list{kHalf4Image}, false);
  }
  Canvas surfaces, splats, picture;
  std::optional<Canvas> samples;      ///< of a picture, several a pixel
  std::optional<SceneCamera> camera;  ///< that surfaces and splats are of
  bool weak = false;                  ///< splats have the weakest kernels, too
};

GlView::GlView(int width, int height, int side)
    : width_(width),
      height_(height),
      side_(side),
      images_(std::make_unique<Images>(width, height, side)) {}
GlView::~GlView() = default;
GlView::GlView(GlView&&) noexcept = default;
GlView& GlView::operator=(GlView&&) noexcept = default;

std::vector<std::uint8_t> GlView::pixels() const {
  const std::size_t row = 3 * static_cast<std::size_t>(width_);
  std::vector<std::uint8_t> upwards(row * static_cast<std::size_t>(height_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, images_->picture.framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, upwards.data());
  std::vector<std::uint8_t> pixels;
  pixels.reserve(upwards.size());
  for (std::size_t y = static_cast<std::size_t>(height_); y-- > 0;) {
    const auto begin = upwards.begin() + static_cast<std::ptrdiff_t>(y * row);
    pixels.insert(pixels.end(), begin, begin + static_cast<std::ptrdiff_t>(row));
  }
  return pixels;
}

std::array<std::uint8_t, 3> GlView::pixel(int x, int y) const {
  std::array<std::uint8_t, 3> rgb{};
  glBindFramebuffer(GL_READ_FRAMEBUFFER, images_->picture.framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(x, y, 1, 1, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
  return rgb;
}

void GlView::copy(unsigned framebuffer, int x, int y, int scale) const {
  glDisable(GL_FRAMEBUFFER_SRGB);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, images_->picture.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glBlitFramebuffer(0, 0, width_, height_, x, y, x + scale * width_, y + scale * height_,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

struct GlRenderer::State {
  State(const Package& package, int samples_of_area)
      : area_samples(samples_of_area),
        samples(package.samples),
        interpreter(package, samples),
        geometry(package.scene),
        splats(package.samples, samples),
        shade(package.samples.clusters(), samples),
        average(Program::graphics({"screen.glsl"}, {"average.glsl"})) {}

  /// Brings surfaces and splats up to date.
  void look_from(const SceneCamera& camera, bool weak, GlView::Images& images);
  [[nodiscard]] ShadeInput input(const GlView::Images& images) const {
    return {&images.surfaces, &images.splats,  &*lights,
            &*fields,         &*images.camera, background ? &*background : nullptr};
  }
  /// Makes the samples' fields those of a picture that shows that.
  void show(Show wanted);
  void shrink(const Canvas& from, int side, const Canvas& to);
  /// Of the last look_from(): picture samples from the lower left, w 1 where there is a surface.
  std::vector<Eigen::Vector4f> radiance(GlView::Images& images, const Look& look);

  int area_samples;
  SampleBuffers samples;
  Interpreter interpreter;
  GeometryPass geometry;
  SplatPass splats;
  ShadePass shade;
  Program average;
  ScreenTriangle screen;
  std::optional<LightTable> lights;
  std::optional<SampleFields> fields;
  Show shown = Show::kFull;  ///< what the fields are made for
  std::optional<EnvironmentImage> background;
  PassClock clock;
};

void GlRenderer::State::look_from(const SceneCamera& camera, bool weak, GlView::Images& images) {
  const bool stands = images.camera && same_camera(*images.camera, camera);
  if (stands && images.weak == weak) return;
  clock.start();
  if (!stands) geometry.draw(camera, images.surfaces);
  clock.stop("geometry");
  splats.draw(images.surfaces, images.splats, weak);
  clock.stop("splats");
  images.camera = camera;
  images.weak = weak;
}

void GlRenderer::State::show(Show wanted) {
  if (wanted == shown) return;
  interpreter.show(*fields, wanted);
  shown = wanted;
}

void GlRenderer::State::shrink(const Canvas& from, int side, const Canvas& to) {
  to.draw_into();
  average.use();
  average.set("side", side);
  from.read_image_at(0, 0);
  glEnable(GL_FRAMEBUFFER_SRGB);
  screen.draw();
  glDisable(GL_FRAMEBUFFER_SRGB);
}

GlRenderer::GlRenderer(const Package& package, int area_samples)
    : state_(std::make_unique<State>(playable(package), area_samples)) {
  set_lights({});
}
GlRenderer::~GlRenderer() = default;

void GlRenderer::set_lights(std::span<const Light> lights, const MatrixF& environment) {
  if (lights.size() > static_cast<std::size_t>(kMostLights)) {
    throw UserError(
        fmt::format("--backend gl plays up to {} lights at once, not {}; use --backend "
                    "cpu",
                    kMostLights, lights.size()));
  }
  State& s = *state_;
  s.clock.start();
  s.lights.emplace(lights, s.area_samples);
  const int count = s.lights->count();
  if (!s.fields || s.fields->stride != SampleFields::stride_for(count)) {
    s.fields.emplace(s.samples.count, count);
  }
  s.interpreter.run(*s.lights, environment, *s.fields, s.shown);
  s.clock.stop("light");
}

void GlRenderer::set_background(const Environment* environment) {
  state_->background.reset();
  if (environment != nullptr) state_->background.emplace(*environment);
}

void GlRenderer::draw(GlView& view, const SceneCamera& camera, const Look& look) {
  State& s = *state_;
  GlView::Images& images = *view.images_;
  s.look_from(camera, look.show == Show::kVisibility, images);
  s.clock.start();
  s.show(look.show);
  const Canvas& canvas = images.samples ? *images.samples : images.picture;
  s.shade.draw(s.input(images), colours_of(look.show), look, canvas);
  if (images.samples) s.shrink(canvas, view.side_, images.picture);
  s.clock.stop("shade");
}

std::vector<Eigen::Vector4f> GlRenderer::State::radiance(GlView::Images& images, const Look& look) {
  show(look.show);
  const Canvas canvas(images.surfaces.width(), images.surfaces.height(), {kVec4Image}, false);
  shade.draw(input(images), Colours::kRadiance, look, canvas);
  std::vector<Eigen::Vector4f> values(static_cast<std::size_t>(canvas.width()) *
                                      static_cast<std::size_t>(canvas.height()));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, canvas.framebuffer());
  glReadPixels(0, 0, canvas.width(), canvas.height(), GL_RGBA, GL_FLOAT, values.data());
  return values;
}

float GlRenderer::own_exposure(GlView& view, const SceneCamera& camera, const Look& look) {
  state_->look_from(camera, false, *view.images_);
  Look full = look;
  full.show = Show::kFull;
  std::vector<Vec3f> seen;
  for (const Eigen::Vector4f& v : state_->radiance(*view.images_, full)) {
    if (v.w() > 0.0F) seen.emplace_back(v.head<3>());
  }
  return prt::own_exposure(seen);
}

std::vector<float> GlRenderer::radiance(GlView& view, const SceneCamera& camera, const Look& look) {
  state_->look_from(camera, false, *view.images_);
  const std::vector<Eigen::Vector4f> samples = state_->radiance(*view.images_, look);
  const int side = view.side_;
  const float share = 1.0F / static_cast<float>(side * side);
  std::vector<float> pixels(std::size_t{3} * static_cast<std::size_t>(view.width_) *
                            static_cast<std::size_t>(view.height_));
  for (std::size_t i = 0; i < samples.size(); ++i) {  // from the lower left; w: 0 where no surface
    const auto across = static_cast<std::size_t>(view.width_) * static_cast<std::size_t>(side);
    const std::size_t x = i % across / static_cast<std::size_t>(side);
    const std::size_t up = i / across / static_cast<std::size_t>(side);
    const std::size_t y = static_cast<std::size_t>(view.height_) - 1 - up;
    const float kept = state_->background ? 1.0F : samples[i].w();
    float* pixel = &pixels[3 * (y * static_cast<std::size_t>(view.width_) + x)];
    for (Eigen::Index c = 0; c < 3; ++c) pixel[c] += share * kept * samples[i][c];
  }
  return pixels;
}

MatrixF GlRenderer::sky() const { return state_->interpreter.sky(); }
MatrixF GlRenderer::direct() const { return state_->interpreter.direct(); }
MatrixF GlRenderer::indirect() const { return state_->interpreter.indirect(); }
void GlRenderer::measure(bool on) { state_->clock.measure(on); }
PassTimes GlRenderer::take_times() { return state_->clock.take(); }

}  // namespace prt::gl
