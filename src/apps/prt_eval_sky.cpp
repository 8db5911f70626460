#include "apps/prt_eval_sky.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/prt_eval_report.h"
#include "evaluate/compare_sky.h"
#include "package/read.h"
#include "player/environment_light.h"
#include "scene/embree/embree_ray_caster.h"

namespace prt {
namespace {

using nlohmann::json;

struct MeasuredSkies {
  std::vector<SkyErrors> skies;
  std::vector<double> play_ms;
  double reference_seconds = 0.0;
};

MeasuredSkies measure_skies(const Package& package, const ReferenceSettings& settings,
                            const std::vector<std::string>& specs) {
  const int order = environment_order(package);
  const auto caster = make_embree_ray_caster(package.scene);
  const SenderSearch search(package.scene, package.samples);
  const Evaluator player(package);
  const ReferenceInputs inputs{package.scene, *caster, package.samples, search};
  MeasuredSkies measured;
  const ProgressLine progress("environment", specs.size());
  for (std::size_t k = 0; k < specs.size(); ++k) {
    progress.at(k);
    const Environment environment = parse_environment(specs[k]);
    const auto start = std::chrono::steady_clock::now();
    const TestPoints reference = trace_sky_reference(inputs, settings, k, environment, 0, [] {});
    measured.reference_seconds += seconds_since(start);
    const EnvironmentLight light(environment, order);
    const auto before_play = std::chrono::steady_clock::now();
    static_cast<void>(player.evaluate({}, light.coefficients()));
    measured.play_ms.push_back(1000.0 * seconds_since(before_play));
    measured.skies.push_back(compare_sky(player, light.coefficients(), reference));
    if (const auto bad = measured.skies.back().not_finite(); bad > 0) {
      throw std::runtime_error(
          fmt::format("{} values under {} are not finite; the package or the reference is wrong",
                      bad, specs[k]));
    }
  }
  return measured;
}

void print_sky_table(const json& report) {
  fmt::print(
      "{} environments, order {}, {} points at samples and on the surface, {} paths each, "
      "seed {}\n\n",
      report["environments"].get<std::size_t>(), report["order"].get<int>(),
      report["points"].get<std::size_t>(), report["spp"].get<int>(),
      report["seed"].get<std::uint64_t>());
  print_head();
  for (const char* part : {"total", "direct", "indirect"}) {
    print_row(fmt::format("{}, samples", part).c_str(), report[part]);
    print_row(fmt::format("{}, surface", part).c_str(), report[part]["surface"]);
  }
  fmt::print("\n  surface that no sample reaches: {}\n", percent(report["unreached_share"]));
  print_bake_figures(report);
}

}  // namespace

void report_sky_error(const EvalCommand& command) {
  const Package package = read_package(command.input);
  require_environment(package, command.input.string());
  ReferenceSettings settings;
  settings.seed = command.seed;
  settings.paths = command.paths;
  const MeasuredSkies measured = measure_skies(package, settings, command.environments);
  json report = sky_error_report(measured.skies);
  report["environment"] = command.environments;
  report["order"] = environment_order(package);
  report["seed"] = command.seed;
  report["spp"] = command.paths;
  report["points"] = settings.points;
  add_bake_figures(command, report);
  report["play_ms"] = quantile(measured.play_ms, 0.5);
  report["reference_seconds"] = measured.reference_seconds;
  write_eval_report(command, report, print_sky_table);
}

}  // namespace prt
