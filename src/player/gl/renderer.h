// Plays a package on OpenGL 4.3 core: the program runs as compute passes at the samples, pictures
// are drawn deferred, so that cost follows pixels and not overdraw (Leonhardt & Bohn, §5). What it
// shows is what the CPU shows (player/evaluator.h, player/picture.h); a test compares them.
//
// All of it needs one current OpenGL context, OffscreenContext's, a window's or an engine's; it
// changes the context's state and binds nothing back.
//
// Stereo: light work is done once for any number of views; each eye is a GlView of its own.
//
//   renderer.set_lights(lights);                 // light work, once per change
//   for (GlView* eye : {&left, &right}) {
//     renderer.draw(*eye, eye_camera, look);     // geometry and splats only if its camera moved
//   }
//
// An OpenXR session in the same context feeds its swap chain so: make a GlView of the size that
// xrEnumerateViewConfigurationViews recommends for each view, once. Each frame, after
// xrLocateViews, turn each XrView's pose into a SceneCamera (eye = position, target = position +
// rotated -Z, up = rotated Y; where the XrFovf is not symmetric, take the largest of its four
// angles for a symmetric camera and draw only the part that the swap chain shows, by copy()'s
// offset). Acquire and wait for the image, attach its texture to a framebuffer of yours, draw(),
// and copy() into that framebuffer; release the image and end the frame. Swap chain formats are
// best GL_SRGB8_ALPHA8: copy() moves sRGB bytes unchanged.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "player/evaluator.h"
#include "player/picture.h"

namespace prt::gl {

/// More lights than this do not fit into a pixel's registers, more samples not into its lists or a
/// dispatch.
inline constexpr int kMostLights = 29;
inline constexpr std::size_t kMostSamples = 3'000'000;

/// What OpenGL calls the machine that draws.
std::string renderer_name();

/// How a view is drawn.
struct Look {
  Show show = Show::kFull;
  float exposure = 1.0F;    ///< factor on radiance before the filmic curve
  float turn = 0.0F;        ///< of the environment's picture, degrees about +Y
  float reflection = 0.0F;  ///< share of it that surfaces mirror (SH §7)
};

/// What one camera sees, and what is kept while it stands still: surfaces, and the samples that
/// each pixel takes its light from. `side`² picture samples are averaged for a pixel.
class GlView {
 public:
  /// Sizes in pixels. Throws UserError where this OpenGL has no room for it.
  GlView(int width, int height, int side = 1);
  ~GlView();
  GlView(GlView&&) noexcept;
  GlView& operator=(GlView&&) noexcept;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// The last picture: 8-bit sRGB, top row first.
  [[nodiscard]] std::vector<std::uint8_t> pixels() const;
  /// One pixel of it; waits for the picture to be done. From the lower left.
  [[nodiscard]] std::array<std::uint8_t, 3> pixel(int x, int y) const;
  /// Copies it into another framebuffer (0: the window), its lower left corner at (x, y), each
  /// pixel as a square of `scale`².
  void copy(unsigned framebuffer, int x = 0, int y = 0, int scale = 1) const;

 private:
  friend class GlRenderer;
  struct Images;
  int width_, height_, side_;
  std::unique_ptr<Images> images_;
};

/// Milliseconds of the passes of a frame, in order. Names: light (visibility and direct light at
/// the samples, projection, transfer), geometry, splats, shade.
using PassTimes = std::vector<std::pair<const char*, double>>;

class GlRenderer {
 public:
  /// Uploads the package, which must outlive the renderer. Throws UserError where this OpenGL has
  /// no room for it, or is older than 4.3.
  explicit GlRenderer(const Package& package, int area_samples = 25);
  ~GlRenderer();
  GlRenderer(const GlRenderer&) = delete;
  GlRenderer& operator=(const GlRenderer&) = delete;

  /// Light work at the samples; `environment` as for Evaluator::evaluate. Throws UserError for more
  /// than kMostLights.
  void set_lights(std::span<const Light> lights, const MatrixF& environment = {});
  /// What pictures show behind all surfaces, and mirrored in them; null: nothing. Throws UserError
  /// where this OpenGL has no room for it.
  void set_background(const Environment* environment);
  /// Draws into the view.
  void draw(GlView& view, const SceneCamera& camera, const Look& look);
  /// The exposure that puts what the camera sees where pictures have it (player/picture.h).
  [[nodiscard]] float own_exposure(GlView& view, const SceneCamera& camera, const Look& look = {});

  /// What Picture::radiance holds of a linear picture; look.show is kFull, kDirect or kIndirect.
  [[nodiscard]] std::vector<float> radiance(GlView& view, const SceneCamera& camera,
                                            const Look& look);

  /// Irradiance at the samples, n × 3, W/m²: what Evaluator::evaluate gives.
  [[nodiscard]] MatrixF direct() const;
  [[nodiscard]] MatrixF sky() const;  ///< zero where the package takes no environment
  [[nodiscard]] MatrixF indirect() const;

  /// While on, each pass is waited for and timed: frames take longer.
  void measure(bool on);
  /// Times since the last call, passes of all views together; empty unless measured.
  PassTimes take_times();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace prt::gl
