#include "apps/prt_eval_error.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "apps/prt_eval_report.h"
#include "base/error.h"
#include "base/image_file.h"
#include "base/random.h"
#include "evaluate/compare.h"
#include "evaluate/error_picture.h"
#include "evaluate/reference.h"
#include "package/read.h"
#include "player/set_up.h"
#include "scene/embree/embree_ray_caster.h"
#include "transport/free_space.h"

namespace prt {
namespace {

using nlohmann::json;

struct Measured {
  std::vector<LightErrors> lights;
  std::vector<double> play_ms;
  double reference_seconds = 0.0;
  double paths = 0.0;
};

/// DIR/light-0003.png: where the package is wrong under test light 3.
class Pictures {
 public:
  Pictures(std::filesystem::path folder, const Evaluator& player) : folder_(std::move(folder)) {
    if (folder_.empty()) return;
    camera_ = default_camera(player);
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) {
      throw UserError(
          fmt::format("--pictures {}: cannot be made: {}", folder_.string(), error.message()));
    }
  }
  void draw(const Evaluator& player, const ReferenceInputs& inputs,
            const ReferenceSettings& settings, const Light& light, std::size_t number) const {
    if (folder_.empty()) return;
    const Picture picture =
        draw_error(player, inputs, light, camera_,
                   {.paths = settings.paths,
                    .stream = stream_key(settings.seed, fmt::format("picture {}", number))});
    if (picture.not_finite > 0) {
      throw std::runtime_error(fmt::format(
          "{} values of the picture of test light {} are not finite", picture.not_finite, number));
    }
    write_png(folder_ / fmt::format("light-{:04}.png", number), picture.width, picture.height,
              picture.rgb);
  }

 private:
  std::filesystem::path folder_;
  SceneCamera camera_;
};

Measured measure(const Package& package, const ReferenceSettings& settings, std::size_t lights,
                 const std::filesystem::path& pictures) {
  const auto caster = make_embree_ray_caster(package.scene);
  const SenderSearch search(package.scene, package.samples);
  const Evaluator player(package);
  const ReferenceInputs inputs{package.scene, *caster, package.samples, search};
  Measured measured;
  const Pictures drawn(pictures, player);
  const ProgressLine progress("test light", lights);
  for (std::size_t k = 0; k < lights; ++k) {
    progress.at(k);
    const auto start = std::chrono::steady_clock::now();
    const LightReference reference = trace_reference(inputs, settings, k, 0, [] {});
    measured.reference_seconds += seconds_since(start);
    measured.paths += static_cast<double>(settings.paths) *
                      static_cast<double>(reference.at_samples.points.size() +
                                          reference.on_surface.points.size());
    const auto before_play = std::chrono::steady_clock::now();
    static_cast<void>(player.evaluate({&reference.light, 1}));
    measured.play_ms.push_back(1000.0 * seconds_since(before_play));
    measured.lights.push_back(compare(player, reference));
    drawn.draw(player, inputs, settings, reference.light, k);
    if (const auto bad = measured.lights.back().not_finite(); bad > 0) {
      throw std::runtime_error(
          fmt::format("{} values of test light {} are not finite; the package or the reference is "
                      "wrong",
                      bad, k));
    }
  }
  return measured;
}

/// "light 7 at (1.2, 0.3, 4.0): 12.00 %; cluster 31: 20.00 % of the squared error"
void print_worst(const char* name, const json& figures) {
  const json& light = figures["worst_light"];
  const json& cluster = figures["worst_cluster"];
  if (!light.is_object() || !cluster.is_object()) return;
  const json& p = light["position"];
  fmt::print(
      "  worst {:<9} light {} at {:.2f},{:.2f},{:.2f}: {}; cluster {}: {} of the squared error\n",
      std::string(name) + ":", light["light"].get<std::size_t>(), p[0].get<double>(),
      p[1].get<double>(), p[2].get<double>(), percent(light["rel_rmse"]),
      cluster["cluster"].get<std::size_t>(), percent(cluster["error_share"]));
}

void print_table(const json& report) {
  fmt::print(
      "{} test lights, {} points at samples (direct: all samples) and on the surface, "
      "{} paths each, seed {}\n\n",
      report["lights"].get<std::size_t>(), report["points"].get<std::size_t>(),
      report["spp"].get<int>(), report["seed"].get<std::uint64_t>());
  print_head();
  print_row("indirect, samples", report["indirect"]);
  print_row("indirect, surface", report["indirect"]["surface"]);
  print_row("... of exact direct", report["indirect"]["exact_direct"]);
  print_row("direct, samples", report["direct"]);
  print_row("direct, surface", report["direct"]["surface"]);
  fmt::print("\n");
  print_worst("indirect", report["indirect"]);
  print_worst("direct", report["direct"]);
  fmt::print("  visibility: wrong {}, soft {}, weighted {}\n", percent(report["visibility_error"]),
             percent(report["visibility_error_soft"]),
             percent(report["visibility_error_weighted"]));
  fmt::print("  surface that no sample reaches: {}\n", percent(report["unreached_share"]));
  print_bake_figures(report);
}

}  // namespace

void report_package_error(const EvalCommand& command) {
  const Package package = read_package(command.input);
  require_direct_light(package, command.input.string());
  ReferenceSettings settings;
  settings.seed = command.seed;
  settings.paths = command.paths;
  settings.clearance = command.clearance.value_or(light_clearance(package.samples, kTestClearance));
  const Measured measured = measure(package, settings, command.lights, command.pictures);
  json report = error_report(measured.lights);
  place_in_world(report, package.scene.origin);
  report["seed"] = command.seed;
  report["spp"] = command.paths;
  report["points"] = settings.points;
  report["clearance"] = settings.clearance;
  add_bake_figures(command, report);
  report["play_ms"] = quantile(measured.play_ms, 0.5);
  report["reference_seconds"] = measured.reference_seconds;
  report["reference_paths_per_second"] = measured.paths / measured.reference_seconds;
  write_eval_report(command, report, print_table);
}

}  // namespace prt
