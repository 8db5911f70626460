#include "player/gl/viewer.h"

#include <fmt/format.h>

#include "base/clock.h"
#include "base/image_file.h"
#include "player/gl/panel.h"
#include "player/gl/window.h"

namespace prt::gl {
namespace {

constexpr int kTurntablePictures = 60;
/// Where a frame takes longer than this when the camera moves (ms), frames are drawn at half the
/// resolution until it stands.
constexpr double kSlowFrame = 50.0;
constexpr int kCoarse = 2;
/// Degrees that an environment turns by.
constexpr float kTurnPerPixel = 0.5F;
/// Metres a second on foot, as a share of the scene's diagonal.
constexpr float kWalkSpeed = 0.1F;

bool same_place(const SceneCamera& a, const SceneCamera& b) {
  return a.eye == b.eye && a.target == b.target;
}

class Viewer {
 public:
  Viewer(const Package& package, const Stage& start, const ViewerSettings& settings,
         const std::function<void(const std::string&)>& say)
      : settings_(settings),
        say_(say),
        window_(settings.title, settings.width, settings.height),
        renderer_(package, settings.area_samples) {
    panel_.stage = start;
    panel_.show = settings.show;
    panel_.stereo = settings.stereo;
    panel_.scene_size = package.scene.diagonal();
    panel_.auto_exposure = !settings.exposure;
    panel_.stage.exposure = settings.exposure.value_or(1.0F);
    panel_.has_lights = has_direct_light(package);
    panel_.has_environment = settings.sky != nullptr;
    renderer_.set_background(settings.environment);
    if (settings.sky != nullptr) renderer_.set_lights({}, settings.sky->coefficients(start.turn));
    renderer_.measure(true);
  }

  Stage run() {
    double last = steady_seconds();
    while (window_.open()) {
      const double now = steady_seconds();
      take(window_.begin(), static_cast<float>(now - last));
      last = now;
      draw_panel(panel_);
      draw();
      window_.end();
      write_pictures();
    }
    return panel_.stage;
  }

 private:
  void take(const Input& input, float seconds) {
    SceneCamera& camera = panel_.stage.camera;
    if (input.right.x != 0.0F || input.right.y != 0.0F) {
      camera = panel_.walking ? turned(camera, input.right) : orbited(camera, input.right);
    }
    if (input.wheel != 0.0F) camera = zoomed(camera, input.wheel);
    if (!input.walk.isZero()) {
      camera = walked(camera, kWalkSpeed * panel_.scene_size * seconds * input.walk);
    }
    const bool dragging = input.left.x != 0.0F || input.left.y != 0.0F;
    if (dragging && !panel_.stage.lights.empty()) {
      Light& light = panel_.stage.lights[panel_.selected];
      light = dragged(light, input.left, input.shift, camera, window_.height());
    } else if (dragging && panel_.has_environment) {
      panel_.stage.turn += kTurnPerPixel * input.left.x;
    }
    for (const int key : input.pressed) {
      if (key == 'P') panel_.screenshot = true;
      if (key == 'T') panel_.turntable = true;
      if (key == kKeyPanel) panel_.visible = !panel_.visible;
    }
  }

  void fit() {
    const int width = std::max(2, window_.width());
    const int height = std::max(1, window_.height());
    const bool fits = eyes_ && drawn_stereo_ == panel_.stereo.on && drawn_width_ == width &&
                      eyes_->height() == height && drawn_distance_ == panel_.stereo.eye_distance;
    if (fits) return;
    eyes_.emplace(width, height, panel_.stereo);
    coarse_.emplace(std::max(2, width / kCoarse), std::max(1, height / kCoarse), panel_.stereo);
    drawn_stereo_ = panel_.stereo.on;
    drawn_distance_ = panel_.stereo.eye_distance;
    drawn_width_ = width;
  }

  [[nodiscard]] Look look() const {
    return {panel_.show, panel_.stage.exposure, panel_.stage.turn, panel_.stage.reflection};
  }

  void draw() {
    fit();
    const auto& lights = panel_.stage.lights;
    const float turn = panel_.stage.turn;
    if (turn != turned_ || lights != lit_) {
      const EnvironmentLight* sky = settings_.sky;
      renderer_.set_lights(lights, sky != nullptr ? sky->coefficients(turn) : MatrixF());
      lit_ = lights;
      turned_ = turn;
    }
    SceneCamera camera = panel_.stage.camera;
    if (turntable_ >= 0) camera = turntable(camera, float(turntable_) / kTurntablePictures);
    if (std::exchange(panel_.auto_exposure, false)) {
      panel_.stage.exposure = eyes_->own_exposure(renderer_, camera, look());
    }
    const bool moving = last_camera_ && !same_place(*last_camera_, camera);
    const bool coarse = moving && slow_ && turntable_ < 0 && !panel_.screenshot;
    Eyes& eyes = coarse ? *coarse_ : *eyes_;
    eyes.draw(renderer_, camera, look());
    eyes.copy(0, coarse ? kCoarse : 1);
    const PassTimes times = renderer_.take_times();
    if (moving && !coarse) slow_ = total(times) > kSlowFrame;
    last_camera_ = camera;
    add_frame(panel_, times);
  }

  /// Pictures hold what the renderer made, without the panel.
  void write_pictures() {
    if (std::exchange(panel_.screenshot, false)) {
      write(fmt::format("{}_{:03}.png", settings_.pictures, screenshots_++));
    }
    if (std::exchange(panel_.turntable, false) && turntable_ < 0) {
      turntable_ = 0;  // the next frame is its first picture
      return;
    }
    if (turntable_ < 0) return;
    write(fmt::format("{}_turntable_{:03}.png", settings_.pictures, turntable_));
    turntable_ = turntable_ + 1 < kTurntablePictures ? turntable_ + 1 : -1;
  }

  void write(const std::string& name) {
    write_png(name, eyes_->width(), eyes_->height(), eyes_->pixels());
    say_("wrote " + name);
  }

  const ViewerSettings& settings_;
  const std::function<void(const std::string&)>& say_;
  Window window_;
  GlRenderer renderer_;
  PanelState panel_;
  std::optional<Eyes> eyes_;
  std::optional<Eyes> coarse_;  // for frames while the camera moves
  std::optional<SceneCamera> last_camera_;
  bool slow_ = false;  // the last such frame in full was
  bool drawn_stereo_ = false;
  float drawn_distance_ = 0.0F;
  int drawn_width_ = 0;
  std::vector<Light> lit_;  // what the renderer has
  float turned_ = 0.0F;
  int screenshots_ = 0;
  int turntable_ = -1;  // its next picture; -1: none
};

}  // namespace

Stage run_viewer(const Package& package, const Stage& start, const ViewerSettings& settings,
                 const std::function<void(const std::string&)>& say) {
  return Viewer(package, start, settings, say).run();
}

}  // namespace prt::gl
