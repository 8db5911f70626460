// prt_play: looks at a package.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/program.h"
#include "apps/prt_play_command.h"
#include "apps/prt_play_gl.h"
#include "apps/statistics.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/image_file.h"
#include "base/log.h"
#include "package/read.h"
#include "player/environment_light.h"
#include "player/set_up.h"

namespace prt {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// An environment as it is played and shown.
struct Sky {
  Environment environment;
  EnvironmentLight light;
};

/// Those asked for. With an environment and no light, none; with neither, the player's choice of
/// what the package takes.
std::vector<Light> chosen_lights(const PlayCommand& command, const Evaluator& evaluator) {
  const Package& package = evaluator.package();
  if (!command.lights.empty()) {
    require_direct_light(package, command.package);
    return lights_in(package.scene.origin, command.lights);
  }
  if (!command.environment.empty() || !has_direct_light(package)) return {};
  return {default_light(evaluator)};
}

std::optional<Sky> chosen_sky(const PlayCommand& command, const Package& package) {
  const bool asked = !command.environment.empty();
  if (!asked && has_direct_light(package)) return std::nullopt;
  require_environment(package, command.package);
  const Environment environment =
      (asked ? parse_environment(command.environment) : default_environment())
          .turned(command.rotate);
  return Sky{environment, EnvironmentLight(environment, environment_order(package))};
}

struct Session {
  const PlayCommand& command;
  Package package;
  Evaluator evaluator;
  std::vector<Light> lights;
  std::optional<Sky> sky;
  SceneCamera camera;
  PictureSettings picture;

  explicit Session(const PlayCommand& c)
      : command(c),
        package(read_package(c.package)),
        evaluator(package, {.area_samples = c.area_samples, .threads = 0}),
        lights(chosen_lights(c, evaluator)),
        sky(chosen_sky(c, package)),
        camera(c.camera ? c.camera->in(package.scene.origin) : default_camera(evaluator)),
        picture(c.picture) {
    if (sky) picture.environment = &sky->environment;
  }
  Session(const Session&) = delete;  // the picture's settings point into it
  Session& operator=(const Session&) = delete;
};

nlohmann::json describe(const Session& session) {
  return {{"backend", session.command.gl ? "gl" : "cpu"},
          {"samples", session.package.samples.size()},
          {"clusters", session.package.samples.clusters()},
          {"triangles", session.package.scene.triangles.size()},
          {"lights", session.lights.size()},
          {"environment_order", environment_order(session.package)},
          {"package_bytes", std::filesystem::file_size(session.command.package)}};
}

/// One light change, timed; the environment is turned by so many degrees.
void relight(const Session& session, std::span<const Light> lights, double turn,
             SampleIrradiance& irradiance, std::vector<double>& times) {
  const auto start = Clock::now();
  const MatrixF sky = session.sky ? session.sky->light.coefficients(turn) : MatrixF();
  session.evaluator.evaluate(lights, sky, irradiance);
  times.push_back(milliseconds_since(start));
}

/// For the given time: light changes in one half, pictures in the other.
void bench(const Session& session, nlohmann::json& report) {
  const double budget = 500.0 * session.command.bench_seconds;
  std::vector<double> play;
  std::vector<double> draw;
  auto start = Clock::now();
  SampleIrradiance irradiance;
  std::vector<Light> lights = session.lights;
  do {
    // A step to and fro: what stands still would not be computed again.
    const float step = 1e-4F * session.package.scene.diagonal();
    for (Light& light : lights) light.position.x() += play.size() % 2 == 0 ? step : -step;
    relight(session, lights, static_cast<double>(play.size()), irradiance, play);
  } while (milliseconds_since(start) < budget);
  start = Clock::now();
  do {
    const auto frame = Clock::now();
    static_cast<void>(render(session.evaluator, irradiance, session.camera, session.picture));
    draw.push_back(milliseconds_since(frame));
  } while (milliseconds_since(start) < budget);
  report["play_ms"] = median(play);
  report["light_changes"] = play.size();
  report["picture_ms"] = median(draw);
  report["pictures"] = draw.size();
}

void draw(const Session& session, nlohmann::json& report) {
  std::vector<double> times;
  SampleIrradiance irradiance;
  relight(session, session.lights, 0.0, irradiance, times);
  PictureSettings settings = session.picture;
  settings.samples_per_side = kKeptSamples;
  const Picture picture = render(session.evaluator, irradiance, session.camera, settings);
  if (settings.linear) {
    write_exr(session.command.out, picture.width, picture.height, picture.radiance);
  } else {
    write_png(session.command.out, picture.width, picture.height, picture.rgb);
  }
  if (!report.contains("play_ms")) report["play_ms"] = times.front();
  report["picture"] = session.command.out;
  report["exposure"] = picture.exposure;
  const auto share = [&](std::size_t count) {
    return static_cast<double>(count) /
           static_cast<double>(std::max<std::size_t>(1, picture.covered));
  };
  report["unreached_share"] = share(picture.unreached);
  report["hole_share"] = share(picture.holes);
  report["not_finite"] = picture.not_finite;
  if (picture.not_finite > 0) {
    log::warn("{} of the picture's samples have values that are not finite", picture.not_finite);
  }
  if (picture.holes > 0) {
    log::warn("{:.3f} % of the picture lies on sampled faces where no sample is near",
              100.0 * share(picture.holes));
  }
}

/// Frames of the GL back end.
void print_bench(const nlohmann::json& bench) {
  for (const auto& [what, figures] : bench.items()) {
    std::string passes;
    for (const auto& [pass, ms] : figures["pass_ms"].items()) {
      passes += fmt::format("{}{} {:.1f}", passes.empty() ? "" : ", ", pass, ms.get<double>());
    }
    fmt::print("{}: {:.1f} fps, {:.1f} ms a frame ({})\n", what, figures["fps"].get<double>(),
               figures["frame_ms"].get<double>(), passes);
  }
}

void print(const nlohmann::json& report, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", report.dump(2));
    return;
  }
  fmt::print("{} samples in {} clusters, {} lights\n", report["samples"].dump(),
             report["clusters"].dump(), report["lights"].dump());
  if (report.contains("play_ms")) {
    fmt::print("light change {:.2f} ms\n", report["play_ms"].get<double>());
  }
  if (report.contains("bench")) print_bench(report["bench"]);
  if (report.contains("picture_ms")) {
    fmt::print("picture {:.1f} ms\n", report["picture_ms"].get<double>());
  }
  if (report.contains("picture")) {
    fmt::print("wrote {}\n", report["picture"].get<std::string>());
  }
}

ExitCode run(int argc, char** argv) {
  std::string message;
  const auto command = parse_play_command(argc, argv, message);
  if (!command) {
    fmt::print("{}", message);
    return ExitCode::kDone;
  }
  [[maybe_unused]] const double start = steady_seconds();
  const Session session(*command);
  nlohmann::json report = describe(session);
#ifdef PRT_HAVE_GL
  if (command->gl) {
    play_gl(*command,
            {session.package, session.lights, session.sky ? &session.sky->environment : nullptr,
             session.sky ? &session.sky->light : nullptr, session.camera, start},
            report);
    print(report, command->json);
    return ExitCode::kDone;
  }
#endif
  if (command->bench_seconds > 0.0) bench(session, report);
  if (!command->out.empty()) draw(session, report);
  if (!report.contains("play_ms")) {
    std::vector<double> times;
    SampleIrradiance irradiance;
    relight(session, session.lights, 0.0, irradiance, times);
    report["play_ms"] = times.front();
  }
  print(report, command->json);
  return ExitCode::kDone;
}

}  // namespace
}  // namespace prt

int main(int argc, char** argv) {
  prt::log::set_up(0);
  return prt::run_program("prt_play", [&] { return prt::run(argc, argv); });
}
