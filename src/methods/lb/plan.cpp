#include "methods/lb/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "methods/common/inputs.h"
#include "methods/common/rays.h"
#include "methods/common/sampling.h"
#include "methods/lb/near.h"
#include "methods/lb/needless.h"
#include "methods/lb/regions.h"
#include "methods/lb/scene_part.h"

namespace prt::lb {

namespace {

constexpr const char* kLightFunctions = "light_functions";
constexpr std::size_t kLightsPerTask = 250;
// The first snapshot bases; doubled while the measured residual stays above the tolerance.
constexpr int kSnapshotRank = 56;
constexpr int kTransferRank = 50;
// An entry of less weight than so many mean rays is more noise than knowledge, and most entries are
// of that kind: one by one they would cost more than all the rest.
constexpr double kNearRays = 6.0;
// Example lights of a region at least, however many regions share the lights of a window.
constexpr std::size_t kLeastLights = kLightsPerTask;
// From so many bounces on all of them cost no more: the same reduced system is solved.
constexpr int kMostCounted = 2;

/// Plans stage by stage; holds what all stages need.
class Planner {
 public:
  Planner(const PlanInputs& inputs, Plan& plan)
      : in_(inputs), options_(inputs.options()), plan_(plan) {}

  void run() {
    plan_stages();
    if (clusters_ == 0) return;
    if (all_done("visibility")) {
      say(needless_visibility(in_, clusters_));
    } else {
      plan_.complete = false;  // what it left out is still to be said
    }
  }

 private:
  void plan_stages() {
    if (!plan_sampling(in_, plan_)) return;
    clusters_ = plan_rays(in_, plan_);
    const auto samples = in_.result(kSamplesTask);
    begin_ = samples->vector<std::uint32_t>("cluster_begin");
    plan_.results = {kSamplesTask};
    places_ = cluster_places(*samples, most_region_clusters(options_, clusters_));
    for (TaskSpec& task : plan_.tasks) {
      if (task.kind == "rays") task.place = places_[task.parameters["cluster"].get<std::size_t>()];
    }
    plan_visibility();
    const auto albedo = in_.result(kAlbedoTask);
    if (!albedo) return;
    bounces_ = wanted_bounces(*albedo);
    if (const auto reason = no_indirect_light(*albedo)) {
      plan_.left_out.push_back({"transport", *reason});
      plan_.complete = true;
      return;
    }
    if (!plan_windows()) return;
    plan_lights();
    channels_ = colour_channels(*albedo);
    if (channels_ == 1) {
      plan_.left_out.push_back(
          {"two colour channels", "the scene is grey: one channel serves all"});
    }
    if (photons()) {
      plan_photons();
    } else {
      plan_gather();
    }
  }

  TaskSpec make(const std::string& kind, const std::string& id, std::vector<std::string> inputs,
                unsigned scene_parts, double cost) const {
    TaskSpec spec;
    spec.id = id;
    spec.kind = kind;
    spec.version = 1;
    spec.inputs = std::move(inputs);
    spec.scene_parts = scene_parts;
    spec.cost = cost;
    return spec;
  }
  [[nodiscard]] double size_of(std::size_t c) const { return begin_[c + 1] - begin_[c]; }
  [[nodiscard]] std::uint64_t seed() const { return options_.get<std::uint64_t>("seed"); }
  [[nodiscard]] std::vector<std::string> all(const std::string& stage, std::size_t count) const {
    std::vector<std::string> ids;
    for (std::size_t i = 0; i < count; ++i) ids.push_back(numbered(stage, i));
    return ids;
  }
  [[nodiscard]] bool all_done(const std::string& stage) const {
    return std::ranges::all_of(all(stage, clusters_),
                               [&](const std::string& id) { return in_.result(id) != nullptr; });
  }
  void say(const std::vector<LeftOut>& left_out) {
    plan_.left_out.insert(plan_.left_out.end(), left_out.begin(), left_out.end());
  }
  /// Adds one task per cluster; `adapt` fills in what is its own.
  template <typename Adapt>
  void per_cluster(const std::string& kind, const std::string& stage, Adapt&& adapt) {
    for (std::size_t c = 0; c < clusters_; ++c) {
      TaskSpec spec = make(kind, numbered(stage, c), {}, kNoScene, 1.0);
      spec.parameters["cluster"] = c;
      adapt(spec, c);
      if (spec.place.empty() && std::ranges::count(spec.inputs, numbered("rays", c)) > 0) {
        spec.place = places_[c];
      }
      plan_.tasks.push_back(spec);
    }
  }

  void plan_visibility() {
    per_cluster("visibility", "visibility", [&](TaskSpec& spec, std::size_t c) {
      spec.inputs = {numbered("rays", c), kSamplesTask};
      spec.version = 2;
      spec.parameters = {{"rank", options_.get<int>("lb.visibility_rank")},
                         {"bits", options_.get<int>("compression.bits")}};
      spec.cost = 2e-4 * size_of(c);
      plan_.results.push_back(spec.id);
    });
  }

  // ---- regions and windows ---------------------------------------------------------------------

  static void append(std::vector<std::string>& ids, const std::vector<std::string>& more) {
    ids.insert(ids.end(), more.begin(), more.end());
  }
  /// False while it is not known which clusters go together.
  bool plan_windows() {
    const std::size_t most = most_region_clusters(options_, clusters_);
    if (clusters_ <= most) {
      regions_ = Regions::whole(clusters_);
      return true;
    }
    per_cluster("reach", "reach", [&](TaskSpec& spec, std::size_t c) {
      spec.inputs = {kSamplesTask, numbered("rays", c)};
      spec.cost = 5e-5 * size_of(c);
    });
    TaskSpec spec = make(kWindowsTask, kWindowsTask, {kSamplesTask, kAlbedoTask}, kNoScene, 1.0);
    append(spec.inputs, all("reach", clusters_));
    spec.version = 2;
    spec.parameters = {{"region_clusters", most},
                       {"tolerance", options_.get<double>("lb.window_tolerance")},
                       {"most_clusters", most_window_clusters(most)}};
    plan_.tasks.push_back(spec);
    plan_.results.emplace_back(kWindowsTask);
    const auto windows = in_.result(kWindowsTask);
    if (!windows) return false;
    regions_ = Regions(get_regions(*windows), clusters_);
    // A window of such a scene lets light out and would not notice.
    if (bounces() < 0 && windows->attribute<double>("gain") >= kMostGain) {
      throw UserError(
          "scene: light is as good as never lost: some albedo is too near 1 in a closed space; "
          "lower "
          "it or set transport.bounces");
    }
    const double error = windows->attribute<double>("error");
    if (windows->attribute<double>("mean_window") >= static_cast<double>(clusters_)) return true;
    plan_.left_out.push_back(
        {"transfer between distant clusters",
         fmt::format(
             "{} regions exchange light with {:.0f} of {} clusters in the mean; some {:.2g} "
             "of a uniformly lit region's indirect light comes from outside{}",
             regions_.count(), windows->attribute<double>("mean_window"), clusters_, error,
             error > options_.get<double>("lb.window_tolerance")
                 ? ", more than lb.window_tolerance: windows hold no more clusters (raise "
                   "lb.region_clusters for larger ones)"
                 : "")});
    return true;
  }

  // ---- direct light ----------------------------------------------------------------------------

  void plan_lights() {
    const std::size_t count =
        regions_.lights(options_.get<std::size_t>("lb.example_lights"), kLeastLights);
    std::vector<std::vector<std::string>> lights(regions_.count());
    for (std::size_t r = 0; r < regions_.count(); ++r) {
      for (std::size_t first = 0; first < count; first += kLightsPerTask) {
        const std::string id = regions_.several()
                                   ? fmt::format("lights/{:04}-{}", r, first / kLightsPerTask)
                                   : numbered("lights", first / kLightsPerTask);
        TaskSpec spec = make("lights", id, {kSamplesTask}, kGeometry, 1.0);
        spec.parameters = {
            {"seed", seed()}, {"first", first}, {"count", std::min(kLightsPerTask, count - first)}};
        regions_.place(spec, r);
        lights[r].push_back(spec.id);
        plan_.tasks.push_back(spec);
      }
    }
    const auto lit_by = regions_.lit_by();
    per_cluster("light_basis", "light_basis", [&](TaskSpec& spec, std::size_t c) {
      spec.inputs = {kSamplesTask, kAlbedoTask, numbered("rays", c)};
      for (const std::size_t r : lit_by[c]) append(spec.inputs, lights[r]);
      spec.scene_parts = kGeometry;
      spec.parameters["rank"] = options_.get<int>("lb.light_rank");
      spec.parameters["near_share"] = near_share();
      if (regions_.several()) {
        spec.parameters["light_regions"] = lit_by[c];
        spec.parameters["lights_inputs"] = lights[0].size();
        spec.parameters["lights"] = count;
      }
      spec.version = 2;
      spec.cost = 1.5e-7 * static_cast<double>(count * lit_by[c].size()) * size_of(c);
      regions_.place(spec, regions_.of(c));
    });
    for (std::size_t r = 0; r < regions_.count(); ++r) {
      TaskSpec bundle = make("light_functions",
                             regions_.several() ? numbered("region_functions", r) : kLightFunctions,
                             {kSamplesTask}, kNoScene, 1.0);
      append(bundle.inputs, numbered_all("light_basis", regions_[r].clusters));
      bundle.parameters = {{"rank", options_.get<int>("lb.light_rank")},
                           {"tolerance", light_tolerance(options_)}};
      bundle.version = 3;
      regions_.place(bundle, r);
      plan_.tasks.push_back(bundle);
    }
    if (regions_.several()) plan_window_functions();
    plan_.results.emplace_back(kLightFunctions);
    if (const auto done = in_.result(kLightFunctions)) say(needless_light_functions(*done));
  }

  /// What each window's tasks read, and for the package the functions of all clusters.
  void plan_window_functions() {
    const auto collect = [&](const std::string& id, const std::vector<std::size_t>& from) {
      TaskSpec spec = make("window_functions", id, {kSamplesTask}, kNoScene, 1.0);
      for (const std::size_t r : from) spec.inputs.push_back(numbered("region_functions", r));
      spec.parameters["from"] = from;
      return spec;
    };
    std::vector<std::size_t> every;
    for (std::size_t r = 0; r < regions_.count(); ++r) {
      every.push_back(r);
      TaskSpec spec = collect(regions_.light_functions(r), regions_.in_window(r));
      regions_.place(spec, r);
      plan_.tasks.push_back(spec);
    }
    TaskSpec whole = collect(kLightFunctions, every);
    whole.inputs.emplace_back(kWindowsTask);
    plan_.tasks.push_back(whole);
  }

  void add_compression(TaskSpec& spec) const {
    spec.parameters["bits"] = options_.get<int>("compression.bits");
    spec.parameters["tolerance"] = options_.get<double>("compression.tolerance");
    spec.parameters["rank"] = kTransferRank;
  }
  [[nodiscard]] bool photons() const { return options_.get<std::string>("lb.solver") == "photons"; }
  /// Entries of the one-bounce operator above it are kept as they are; photons know no entries.
  [[nodiscard]] double near_share() const {
    if (photons()) return 1.0;
    return std::min(1.0, std::max(options_.get<double>("lb.near_share"), least_near_share()));
  }
  [[nodiscard]] double least_near_share() const {
    return kNearRays / options_.get<double>("rays.directions");
  }
  [[nodiscard]] std::optional<std::string> no_indirect_light(const Artifact& albedo) const {
    if (albedo.attribute<double>("largest") <= 0.0) {
      return "every surface is black: there is no indirect light";
    }
    if (bounces() == 0) return "transport.bounces is 0: no indirect light is wanted";
    return std::nullopt;
  }

  /// Bounces to compute; below 0: all there are. Three cost as much as all do.
  [[nodiscard]] int wanted_bounces(const Artifact& albedo) {
    if (!options_.is_auto("transport.bounces")) return options_.get<int>("transport.bounces");
    const double largest = albedo.attribute<double>("largest");
    const int enough = sufficient_bounces(largest, options_.get<double>("transport.tolerance"));
    if (enough > kMostCounted || largest <= 0.0) return -1;
    plan_.left_out.push_back(
        {enough == 1 ? "all bounces but the first" : fmt::format("bounces after {}", enough),
         fmt::format("the largest albedo is {:.3g}: they are at most {:.1e} of the indirect light",
                     largest, std::pow(largest, enough))});
    return enough;
  }
  [[nodiscard]] int bounces() const { return bounces_; }

  [[nodiscard]] std::size_t channels() const { return static_cast<std::size_t>(channels_); }
  [[nodiscard]] int near_bounces() const {
    return bounces() < 0 ? kNearBounces : std::min(kNearBounces, bounces());
  }

  void plan_near() {
    if (near_share() > options_.get<double>("lb.near_share")) {
      plan_.left_out.push_back(
          {fmt::format("near transfer below {:.3g} of a hemisphere", near_share()),
           fmt::format("that is the weight of {} of {} rays in the mean: less is noise", kNearRays,
                       options_.get<int>("rays.directions"))});
    }
    per_cluster("near", "near", [&](TaskSpec& spec, std::size_t c) {
      spec.inputs = {kSamplesTask, numbered("rays", c)};
      spec.parameters["near_share"] = near_share();
      spec.cost = 5e-5 * size_of(c);
      plan_.results.push_back(spec.id);
    });
  }

  void plan_gather() {
    plan_near();
    for (int round = 0; round < kMostRounds; ++round) {
      plan_round(round);
      if (bounces() >= 0) break;  // a truncated series has no residual to judge
      const auto residual = measured_residual(round);
      if (!residual) return;
      if (*residual <= options_.get<double>("transport.tolerance")) break;
    }
    finish();
  }

  /// Relative residual of the transport equation, once every task that measures it is done.
  [[nodiscard]] std::optional<double> measured_residual(int round) const {
    double squared = 0.0;
    double source = 0.0;
    for (std::size_t c = 0; c < clusters_; ++c) {
      const auto part = in_.result(numbered(stage("residual", round), c));
      if (!part) return std::nullopt;
      squared += part->attribute<double>("squared_residual");
      source += part->attribute<double>("squared_source");
    }
    return source > 0.0 ? std::sqrt(squared / source) : 0.0;
  }
  static std::string stage(const std::string& kind, int round) {
    return round == 0 ? kind : fmt::format("{}-{}", kind, round + 1);
  }

  void plan_round(int round) {
    const int rank = kSnapshotRank << round;
    const double tolerance = options_.get<double>("transport.tolerance") / (1 << round);
    const std::string snapshot = stage("snapshot", round);
    const std::string galerkin = stage("galerkin", round);
    const std::string bundle = stage("snapshot_functions", round);
    const std::string solve = stage("solve", round);
    transfer_stage_ = stage("transfer", round);
    const bool one_bounce = bounces() == 1;
    const auto gather_inputs = [&](std::size_t c, const std::string& functions) {
      return std::vector<std::string>{kSamplesTask, kAlbedoTask, numbered("rays", c), functions};
    };
    // Solutions of a region's channels.
    const auto solved = [&](const std::string& solves, std::size_t r) {
      std::vector<std::string> ids;
      for (std::size_t i = 0; i < channels(); ++i) {
        ids.push_back(numbered(solves, r * channels() + i));
      }
      return ids;
    };
    if (!one_bounce) {
      per_cluster("snapshot", snapshot, [&](TaskSpec& spec, std::size_t c) {
        const std::size_t r = regions_.of(c);
        spec.inputs = gather_inputs(c, regions_.light_functions(r));
        if (round > 0) {  // enriched by what the last round found
          spec.inputs.push_back(regions_.name(stage("snapshot_functions", round - 1), r));
          append(spec.inputs, solved(stage("solve", round - 1), r));
        }
        spec.parameters["channels"] = channels_;
        spec.parameters["rank"] = rank;
        spec.parameters["tolerance"] = tolerance;
        spec.version = 4;
        spec.cost = 3e-4 * size_of(c);
        regions_.place(spec, r);
      });
      for (std::size_t r = 0; r < regions_.count(); ++r) {
        TaskSpec collected =
            make("snapshot_functions", regions_.name(bundle, r), {kSamplesTask}, kNoScene, 1.0);
        append(collected.inputs, numbered_all(snapshot, regions_[r].window));
        collected.version = 2;
        regions_.place(collected, r);
        plan_.tasks.push_back(collected);
      }
      if (bounces() != 2) {  // what the snapshot bases send each other
        per_cluster("galerkin", galerkin, [&](TaskSpec& spec, std::size_t c) {
          spec.inputs = gather_inputs(c, regions_.name(bundle, regions_.of(c)));
          spec.parameters["channels"] = channels_;
          spec.version = 3;
          spec.cost = 3e-4 * size_of(c);
          regions_.place(spec, regions_.of(c));
        });
      }
      for (std::size_t r = 0; r < regions_.count(); ++r) {
        std::vector<std::string> inputs = numbered_all(snapshot, regions_[r].window);
        if (bounces() != 2) append(inputs, numbered_all(galerkin, regions_[r].window));
        for (std::size_t channel = 0; channel < channels(); ++channel) {
          TaskSpec spec = make("solve", solved(solve, r)[channel], inputs, kNoScene, 1.0);
          spec.parameters = {{"channels", channels_}, {"channel", channel}, {"bounces", bounces()}};
          spec.version = 4;
          const double size = static_cast<double>(regions_[r].window.size()) / kWindowClusters;
          spec.cost = 0.1 + 10.0 * size * size * size;
          regions_.place(spec, r);
          plan_.tasks.push_back(spec);
        }
      }
    }
    per_cluster("transfer", transfer_stage_, [&](TaskSpec& spec, std::size_t c) {
      const std::size_t r = regions_.of(c);
      spec.inputs = gather_inputs(c, regions_.light_functions(r));
      append(spec.inputs, numbered_all("near", regions_[r].window));
      if (!one_bounce) {
        spec.inputs.push_back(regions_.name(bundle, r));
        append(spec.inputs, solved(solve, r));
      }
      spec.parameters["channels"] = channels_;
      spec.parameters["near_bounces"] = near_bounces();
      spec.version = 6;
      add_compression(spec);
      spec.cost = 6e-4 * size_of(c);
      regions_.place(spec, r);
    });
    if (bounces() >= 0) return;
    per_cluster("residual", stage("residual", round), [&](TaskSpec& spec, std::size_t c) {
      spec.inputs = {kSamplesTask, kAlbedoTask, numbered("rays", c)};
      append(spec.inputs, numbered_all(transfer_stage_, regions_.window_of(c)));
      spec.parameters["channels"] = channels_;
      spec.version = 2;
      spec.cost = 5e-5 * size_of(c);
      regions_.place(spec, regions_.of(c));
    });
  }

  void plan_photons() {
    const double photons = options_.get<double>("lb.photons") / static_cast<double>(clusters_);
    std::vector<std::string> inputs = {kSamplesTask, kLightFunctions};
    for (const TaskSpec& task : plan_.tasks) {
      if (task.kind == "cells") inputs.push_back(task.id);
    }
    per_cluster("photons", "photons", [&](TaskSpec& spec, std::size_t) {
      spec.version = 3;
      spec.inputs = inputs;
      spec.scene_parts = kGeometry | kMaterials;
      spec.parameters["photons"] = static_cast<std::uint64_t>(std::ceil(photons));
      spec.parameters["channels"] = channels_;
      spec.parameters["bounces"] = bounces();
      spec.parameters["seed"] = seed();
      spec.cost = 2e-6 * photons;
    });
    per_cluster("photon_transfer", "photon_transfer", [&](TaskSpec& spec, std::size_t c) {
      spec.inputs = {kSamplesTask, kLightFunctions};
      const auto shot = all("photons", clusters_);
      spec.inputs.insert(spec.inputs.end(), shot.begin(), shot.end());
      spec.parameters["channels"] = channels_;
      spec.version = 2;
      add_compression(spec);
      spec.cost = 3e-4 * size_of(c);
    });
    transfer_stage_ = "photon_transfer";
    finish();
  }

  /// The transfer tasks of the last round are what the package is made of.
  void finish() {
    plan_.results.emplace_back(kAlbedoTask);
    for (const std::string& id : all(transfer_stage_, clusters_)) plan_.results.push_back(id);
    plan_.complete = all_done(transfer_stage_);
    if (plan_.complete) say(needless_blocks(in_, transfer_stage_, clusters_));
  }

  const PlanInputs& in_;
  const OptionValues& options_;
  Plan& plan_;
  std::size_t clusters_ = 0;
  Regions regions_;
  std::vector<std::string> places_;  // TaskSpec::place of what reads each cluster's rays
  std::vector<std::uint32_t> begin_;
  int channels_ = 3;
  int bounces_ = -1;
  std::string transfer_stage_;
};

}  // namespace

Plan make_plan(const PlanInputs& inputs) {
  Plan plan;
  plan.plays_lights = true;
  Planner(inputs, plan).run();
  return plan;
}

}  // namespace prt::lb
