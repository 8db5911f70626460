#include "apps/prt_play_gl.h"

#include <cmath>
#include <ctime>
#include <map>
#include <string>

#include "apps/statistics.h"
#include "base/clock.h"
#include "base/image_file.h"
#include "base/log.h"
#include "player/gl/eyes.h"
#include "player/gl/offscreen.h"
#include "player/gl/viewer.h"

namespace prt {
namespace {

/// Of the circle that the light goes round in a bench, as a share of the scene's diagonal.
constexpr float kCircle = 0.02F;
constexpr int kFramesPerRound = 60;

gl::StereoSettings stereo_of(const PlayCommand& command) {
  return {.on = command.stereo, .eye_distance = command.eye_distance};
}

gl::Look look_of(const PlayCommand& command) {
  return {.show = command.picture.show, .reflection = command.picture.reflection};
}

/// The lights as they are, and the environment turned by so many degrees.
void relight(const GlScene& scene, gl::GlRenderer& renderer, const std::vector<Light>& lights,
             double turn = 0.0) {
  renderer.set_lights(lights, scene.sky != nullptr ? scene.sky->coefficients(turn) : MatrixF());
}

std::vector<Light> moved(std::vector<Light> lights, const Scene& scene, int frame) {
  const float angle = 2.0F * kPi * static_cast<float>(frame % kFramesPerRound) / kFramesPerRound;
  const float radius = kCircle * scene.diagonal();
  for (Light& light : lights) {
    light.position += radius * Vec3f(std::cos(angle) - 1.0F, 0.0F, std::sin(angle));
  }
  return lights;
}

/// The camera a step to the side and back: enough for everything to be drawn anew.
SceneCamera moved(SceneCamera camera, int frame) {
  const Vec3f view = camera.target - camera.eye;
  const Vec3f right = view.cross(camera.up).normalized();
  const float step = 0.01F * view.norm() * static_cast<float>(frame % 2);
  camera.eye += step * right;
  return camera;
}

class Bench {
 public:
  Bench(const PlayCommand& command, const GlScene& scene, gl::GlRenderer& renderer)
      : scene_(scene),
        renderer_(renderer),
        eyes_(command.picture.width, command.picture.height, stereo_of(command)),
        seconds_(command.bench_seconds / 3.0),
        look_(look_of(command)) {
    look_.exposure = command.picture.exposure ? *command.picture.exposure
                                              : eyes_.own_exposure(renderer_, scene_.camera, look_);
  }

  nlohmann::json run() {
    const auto light = [&](int i) {
      const double turn = 360.0 * (i % kFramesPerRound) / kFramesPerRound;
      relight(scene_, renderer_, moved(scene_.lights, scene_.package.scene, i), turn);
      look_.turn = scene_.sky != nullptr ? static_cast<float>(turn) : 0.0F;
      eyes_.draw(renderer_, scene_.camera, look_);
    };
    const auto camera = [&](int i) { eyes_.draw(renderer_, moved(scene_.camera, i), look_); };
    const auto still = [&](int) { eyes_.draw(renderer_, scene_.camera, look_); };
    return {{"light_moving", frames(light)},
            {"camera_moving", frames(camera)},
            {"still", frames(still)}};
  }

 private:
  /// Frames per second, then the passes of a frame apart: waiting for each takes time of its own.
  template <typename Frame>
  nlohmann::json frames(const Frame& frame) {
    std::vector<double> times;
    int i = 0;
    frame(i++);
    eyes_.wait();
    const std::clock_t cpu_start = std::clock();
    const double end = steady_seconds() + 0.7 * seconds_;
    do {
      const double start = steady_seconds();
      frame(i++);
      eyes_.wait();
      times.push_back(1000.0 * (steady_seconds() - start));
    } while (steady_seconds() < end);
    const double frame_ms = median(times);
    const double cpu_ms = 1000.0 * static_cast<double>(std::clock() - cpu_start) /
                          (CLOCKS_PER_SEC * static_cast<double>(times.size()));
    return {{"fps", 1000.0 / frame_ms},
            {"frame_ms", frame_ms},
            {"cpu_ms", cpu_ms},
            {"frames", times.size()},
            {"pass_ms", passes(frame, i)}};
  }

  template <typename Frame>
  nlohmann::json passes(const Frame& frame, int i) {
    std::map<std::string, std::vector<double>> times;
    renderer_.measure(true);
    const double end = steady_seconds() + 0.3 * seconds_;
    do {
      frame(i++);
      for (const auto& [pass, ms] : renderer_.take_times()) times[pass].push_back(ms);
    } while (steady_seconds() < end);
    renderer_.measure(false);
    nlohmann::json medians = nlohmann::json::object();
    for (const auto& [pass, values] : times) medians[pass] = median(values);
    return medians;
  }

  const GlScene& scene_;
  gl::GlRenderer& renderer_;
  gl::Eyes eyes_;
  double seconds_;
  gl::Look look_;
};

void draw(const PlayCommand& command, const GlScene& scene, gl::GlRenderer& renderer,
          nlohmann::json& report) {
  gl::Eyes eyes(command.picture.width, command.picture.height, stereo_of(command), kKeptSamples);
  gl::Look look = look_of(command);
  look.exposure = command.picture.exposure ? *command.picture.exposure
                                           : eyes.own_exposure(renderer, scene.camera, look);
  if (command.picture.linear) {
    write_exr(command.out, eyes.width(), eyes.height(),
              eyes.radiance(renderer, scene.camera, look));
  } else {
    eyes.draw(renderer, scene.camera, look);
    write_png(command.out, eyes.width(), eyes.height(), eyes.pixels());
  }
  report["picture"] = command.out;
  report["exposure"] = look.exposure;
}

/// As a window would show it first: in full size, with an exposure of its own.
void first_frame(const PlayCommand& command, const GlScene& scene, gl::GlRenderer& renderer) {
  gl::Eyes eyes(command.picture.width, command.picture.height, stereo_of(command));
  gl::Look look = look_of(command);
  look.exposure = eyes.own_exposure(renderer, scene.camera, look);
  eyes.draw(renderer, scene.camera, look);
  eyes.wait();
}

void play_offscreen(const PlayCommand& command, const GlScene& scene, nlohmann::json& report) {
  const gl::OffscreenContext context;
  gl::GlRenderer renderer(scene.package, command.area_samples);
  renderer.set_background(scene.environment);
  relight(scene, renderer, scene.lights);
  report["renderer"] = gl::renderer_name();
  first_frame(command, scene, renderer);
  report["first_frame_ms"] = 1000.0 * (steady_seconds() - scene.start);
  if (command.bench_seconds > 0.0) report["bench"] = Bench(command, scene, renderer).run();
  renderer.measure(true);
  relight(scene, renderer, scene.lights);
  report["play_ms"] = renderer.take_times().front().second;
  renderer.measure(false);
  if (!command.out.empty()) draw(command, scene, renderer, report);
}

nlohmann::json numbers(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

/// What the user has set up, in the world: to be given to --light and --camera.
nlohmann::json describe(const gl::Stage& stage, const Vec3d& origin) {
  nlohmann::json lights = nlohmann::json::array();
  for (const Light& light : stage.lights) {
    lights.push_back({{"position", numbers(origin + light.position.cast<double>())},
                      {"direction", numbers(light.direction.cast<double>())},
                      {"intensity", numbers(light.intensity.cast<double>())}});
  }
  return {{"lights", lights},
          {"eye", numbers(origin + stage.camera.eye.cast<double>())},
          {"target", numbers(origin + stage.camera.target.cast<double>())},
          {"turn", stage.turn},
          {"exposure", stage.exposure}};
}

void play_in_window(const PlayCommand& command, const GlScene& scene, nlohmann::json& report) {
  const gl::ViewerSettings settings{.title = "prt_play " + command.package,
                                    .width = command.picture.width,
                                    .height = command.picture.height,
                                    .area_samples = command.area_samples,
                                    .show = command.picture.show,
                                    .exposure = command.picture.exposure,
                                    .stereo = stereo_of(command),
                                    .environment = scene.environment,
                                    .sky = scene.sky};
  const auto say = [](const std::string& line) { log::info("{}", line); };
  const gl::Stage end = gl::run_viewer(
      scene.package, {scene.lights, scene.camera, 1.0F, 0.0F, command.picture.reflection}, settings,
      say);
  report["end"] = describe(end, scene.package.scene.origin);
}

}  // namespace

void play_gl(const PlayCommand& command, const GlScene& scene, nlohmann::json& report) {
  const bool window = command.out.empty() && command.bench_seconds == 0.0;
  window ? play_in_window(command, scene, report) : play_offscreen(command, scene, report);
}

}  // namespace prt
