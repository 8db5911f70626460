#include "apps/prt_eval_error.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>

#include "base/atomic_file.h"
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

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One line on a terminal that says how far the lights are; nothing elsewhere.
class ProgressLine {
 public:
  explicit ProgressLine(std::size_t lights) : lights_(lights), shown_(isatty(STDERR_FILENO) != 0) {}
  ~ProgressLine() {
    if (shown_) std::fputs("\r\033[K", stderr);
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  void light(std::size_t number) const {
    if (!shown_) return;
    std::fputs(fmt::format("\rtest light {} of {}", number + 1, lights_).c_str(), stderr);
    std::fflush(stderr);
  }

 private:
  std::size_t lights_;
  bool shown_;
};

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
  const ProgressLine progress(lights);
  for (std::size_t k = 0; k < lights; ++k) {
    progress.light(k);
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

/// The report beside the package; an empty object where there is none.
json bake_report(const std::filesystem::path& package) {
  std::ifstream in(package.parent_path() / "report.json");
  json report = json::parse(in, nullptr, false);
  return report.is_object() ? report : json::object();
}

/// Its "bake_seconds"; null where it has none.
json bake_seconds(const json& report) {
  const auto found = report.find("bake_seconds");
  return found != report.end() && found->is_number() ? *found : json(nullptr);
}

/// CPU seconds by stage, the longest first: {stage, cpu_seconds}; empty where they are not known.
json bake_stages(const json& report) {
  const auto found = report.find("stages");
  if (found == report.end() || !found->is_array()) return json::array();
  std::vector<std::pair<double, std::string>> stages;
  for (const json& s : *found) {
    if (!s.is_object() || !s.contains("stage") || !s.contains("cpu_seconds")) continue;
    if (!s["stage"].is_string() || !s["cpu_seconds"].is_number()) continue;
    stages.emplace_back(s["cpu_seconds"].get<double>(), s["stage"].get<std::string>());
  }
  std::ranges::stable_sort(stages, std::greater<>(), [](const auto& s) { return s.first; });
  json all = json::array();
  for (const auto& [seconds, stage] : stages) {
    all.push_back({{"stage", stage}, {"cpu_seconds", seconds}});
  }
  return all;
}

std::string percent(const json& value) {
  return value.is_number() ? fmt::format("{:.2f} %", 100.0 * value.get<double>()) : "-";
}

void print_row(const char* name, const json& figures) {
  fmt::print("  {:<22}{:>10}{:>10}{:>10}{:>12}{:>12}{:>10}\n", name, percent(figures["rel_rmse"]),
             percent(figures["rel_rmse_light"]["median"]),
             percent(figures["rel_rmse_light"]["p95"]), percent(figures["standard_error"]),
             percent(figures["light_error"]), percent(figures["negative_share"]));
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

void print_stages(const json& stages) {
  constexpr std::size_t kShown = 6;
  if (stages.empty()) return;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, stages.size()); ++i) {
    text += fmt::format("{}{} {:.1f}", i == 0 ? "" : ", ", stages[i]["stage"].get<std::string>(),
                        stages[i]["cpu_seconds"].get<double>());
  }
  fmt::print("  CPU seconds of the bake: {}{}\n", text, stages.size() > kShown ? ", ..." : "");
}

void print_table(const json& report) {
  fmt::print(
      "{} test lights, {} points at samples (direct: all samples) and on the surface, "
      "{} paths each, seed {}\n\n",
      report["lights"].get<std::size_t>(), report["points"].get<std::size_t>(),
      report["spp"].get<int>(), report["seed"].get<std::uint64_t>());
  fmt::print("  {:<22}{:>10}{:>10}{:>10}{:>12}{:>12}{:>10}\n", "relative RMS error", "pooled",
             "median", "95th", "noise", "lights", "negative");
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
  const json& bake = report["bake_seconds"];
  fmt::print("  package {:.2f} MB, player {:.1f} ms per light, bake {}\n",
             report["package_bytes"].get<double>() / 1e6, report["play_ms"].get<double>(),
             bake.is_number() ? fmt::format("{:.1f} s", bake.get<double>()) : "time not known");
  print_stages(report["bake_stages"]);
}

}  // namespace

void report_package_error(const EvalCommand& command) {
  const Package package = read_package(command.input);
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
  report["package_bytes"] = std::filesystem::file_size(command.input);
  const json baked = bake_report(command.input);
  report["bake_seconds"] = bake_seconds(baked);
  report["bake_stages"] = bake_stages(baked);
  report["play_ms"] = quantile(measured.play_ms, 0.5);
  report["reference_seconds"] = measured.reference_seconds;
  report["reference_paths_per_second"] = measured.paths / measured.reference_seconds;
  if (command.json.empty()) {
    print_table(report);
    return;
  }
  const std::string text = report.dump(2) + "\n";
  if (command.json == "-")
    std::fputs(text.c_str(), stdout);
  else
    write_file_atomically(command.json, std::as_bytes(std::span(text)));
}

}  // namespace prt
