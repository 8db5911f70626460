#include "apps/prt_play_gl.h"

#include <cmath>
#include <ctime>
#include <map>
#include <string>

#include "apps/statistics.h"
#include "base/clock.h"
#include "base/image_file.h"
#include "player/gl/offscreen.h"
#include "player/gl/renderer.h"

namespace prt {
namespace {

/// Of the circle that the light goes round in a bench, as a share of the scene's diagonal.
constexpr float kCircle = 0.02F;
constexpr int kFramesPerRound = 60;

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
        view_(command.picture.width, command.picture.height),
        seconds_(command.bench_seconds / 3.0),
        look_{command.picture.show, 1.0F} {
    look_.exposure = command.picture.exposure ? *command.picture.exposure
                                              : renderer_.own_exposure(view_, scene_.camera);
  }

  nlohmann::json run() {
    const auto light = [&](int i) {
      renderer_.set_lights(moved(scene_.lights, scene_.package.scene, i));
      renderer_.draw(view_, scene_.camera, look_);
    };
    const auto camera = [&](int i) { renderer_.draw(view_, moved(scene_.camera, i), look_); };
    const auto still = [&](int) { renderer_.draw(view_, scene_.camera, look_); };
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
    static_cast<void>(view_.pixel(0, 0));
    const std::clock_t cpu_start = std::clock();
    const double end = steady_seconds() + 0.7 * seconds_;
    do {
      const double start = steady_seconds();
      frame(i++);
      static_cast<void>(view_.pixel(0, 0));
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
  gl::GlView view_;
  double seconds_;
  gl::Look look_;
};

void draw(const PlayCommand& command, const GlScene& scene, gl::GlRenderer& renderer,
          nlohmann::json& report) {
  gl::GlView view(command.picture.width, command.picture.height, kKeptSamples);
  gl::Look look{command.picture.show, 1.0F};
  look.exposure = command.picture.exposure ? *command.picture.exposure
                                           : renderer.own_exposure(view, scene.camera);
  renderer.draw(view, scene.camera, look);
  write_png(command.out, view.width(), view.height(), view.pixels());
  report["picture"] = command.out;
  report["exposure"] = look.exposure;
}

}  // namespace

void play_gl_offscreen(const PlayCommand& command, const GlScene& scene, nlohmann::json& report) {
  const gl::OffscreenContext context;
  gl::GlRenderer renderer(scene.package, command.area_samples);
  renderer.set_lights(scene.lights);
  report["renderer"] = gl::renderer_name();
  if (command.bench_seconds > 0.0) report["bench"] = Bench(command, scene, renderer).run();
  renderer.measure(true);
  renderer.set_lights(scene.lights);
  report["play_ms"] = renderer.take_times().front().second;
  renderer.measure(false);
  if (!command.out.empty()) draw(command, scene, renderer, report);
}

}  // namespace prt
