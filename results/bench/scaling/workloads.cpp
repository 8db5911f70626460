#include "scaling/workloads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>

#include "methods/common/sampling.h"
#include "methods/lb/regions.h"

namespace prt::scaling {

namespace {

constexpr double kCitySamplesPerCluster = 1000.0;
// Triangles of the city per sample: a street scene's, as sponza has.
constexpr double kCityTrianglesPerSample = 2.0;

bool grows_with_samples(const std::string& kind) {
  static const std::set<std::string> kKinds = {
      "points",  "samples", "albedo", "light_functions", "snapshot_functions",
      "compare", "evaluate"};
  return kKinds.contains(kind);
}

bool makes_search(const std::string& kind) { return kind == "points" || kind == "samples"; }

/// Stages that only large scenes have, and what thinning in tiles leaves to "points": CPU seconds
/// and bytes per candidate, of the gallery at 1,000,000 samples, thinned in seven tiles.
struct PerCandidate {
  double seconds, bytes;
};
const std::map<std::string, PerCandidate>& tiled_stages() {
  static const std::map<std::string, PerCandidate> kStages = {{"tiles", {2.3e-7, 32.0}},
                                                              {"highest", {2.5e-7, 2.0}},
                                                              {"spacing", {5.5e-8, 0.0}},
                                                              {"thin", {8.3e-7, 4.1}},
                                                              {"points", {2.4e-7, 1.6}}};
  return kStages;
}
std::optional<Load> tiled_load(const std::string& kind, double samples) {
  const SamplingTasks sampling = sampling_tasks(samples);
  const auto stage = tiled_stages().find(kind);
  if (sampling.tiles <= 1.0 || stage == tiled_stages().end()) return std::nullopt;
  const double tasks = kind == "tiles"                       ? sampling.sorting_tasks
                       : kind == "highest" || kind == "thin" ? sampling.tiles
                                                             : 1.0;
  const double candidates = sampling.candidates / tasks;
  return Load{.seconds = stage->second.seconds * candidates,
              .bytes = stage->second.bytes * candidates};
}

/// What a measured bake's tasks took.
Load measured_load(const BakeFacts& facts, const std::string& kind, double samples) {
  const KindFigures& figures = facts.bake.kinds.at(kind);
  Load load{.seconds = figures.seconds, .bytes = figures.bytes};
  if (figures.seconds_per_sample > 0.0) {
    load.seconds = figures.seconds_per_sample * samples;
    load.bytes = figures.bytes_per_sample * samples;
  }
  if (makes_search(kind)) load.use_seconds = facts.set_up.search_seconds;
  return load;
}

GraphSettings measured_settings(const MeasuredBake& bake, double area) {
  GraphSettings settings;
  settings.options = bake.options;
  settings.sizes = bake.sizes;
  settings.area = area;
  settings.spacing = bake.spacing;
  settings.regions = bake.regions;
  settings.centres = bake.centres;
  const std::size_t systems = std::max<std::size_t>(1, bake.regions.size());
  settings.grey = bake.kinds.at("solve").tasks == systems;
  return settings;
}

/// Clusters side by side on a square grid.
struct Grid {
  std::size_t clusters;
  [[nodiscard]] std::size_t side() const {
    return static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(clusters))));
  }
  [[nodiscard]] long x(std::size_t c) const { return static_cast<long>(c % side()); }
  [[nodiscard]] long y(std::size_t c) const { return static_cast<long>(c / side()); }
};

/// A cluster sees those within so many others of it, by the inverse square of their distance; a
/// fifth of its hemispheres is sky.
ClusterExchange city_exchange(const Grid& grid) {
  constexpr long kSeen = 9;
  constexpr double kGround = 0.8;
  ClusterExchange exchange;
  exchange.begin = {0};
  for (std::size_t r = 0; r < grid.clusters; ++r) {
    std::vector<std::pair<std::uint32_t, double>> seen;
    double sum = 0.0;
    for (long dy = -kSeen; dy <= kSeen; ++dy) {
      for (long dx = -kSeen; dx <= kSeen; ++dx) {
        const long x = grid.x(r) + dx;
        const long y = grid.y(r) + dy;
        const long c = y * static_cast<long>(grid.side()) + x;
        const bool inside = x >= 0 && y >= 0 && x < static_cast<long>(grid.side()) &&
                            c < static_cast<long>(grid.clusters);
        const long squared = dx * dx + dy * dy;
        if (!inside || squared > kSeen * kSeen) continue;
        seen.emplace_back(c, 1.0 / static_cast<double>(1 + squared));
        sum += seen.back().second;
      }
    }
    for (const auto& [cluster, share] : seen) {
      exchange.senders.push_back(cluster);
      exchange.shares.push_back(static_cast<float>(kGround * share / sum));
    }
    exchange.begin.push_back(static_cast<std::uint32_t>(exchange.senders.size()));
  }
  return exchange;
}

/// Laws by kind, fitted once.
class GrowthLaws {
 public:
  explicit GrowthLaws(const CityFacts& facts)
      : facts_(facts), middle_(facts.bakes.at(facts.bakes.size() / 2)) {
    // Their rows are as long as all functions within reach.
    for (const std::string kind : {"snapshot", "galerkin", "transfer", "residual"}) {
      seconds_[kind] = fit(kind, &KindFigures::seconds_per_sample);
      bytes_[kind] = fit(kind, &KindFigures::bytes_per_sample);
    }
  }

  [[nodiscard]] Load at(const TaskSpec& task, const TaskSize& size) const {
    const std::string& kind = task.kind;
    if (kind == "solve") return solve(size.reach);
    if (kind == "window_functions") return window_functions(size.samples);
    if (auto tiled = tiled_load(kind, size.samples)) {
      if (makes_search(kind)) tiled->use_seconds = search_seconds(size.samples);
      return *tiled;
    }
    if (grows_with_samples(kind)) return in_proportion(kind, size.samples);
    // Only the bakes in regions have some kinds.
    if (!middle_.bake.kinds.contains(kind))
      return measured_load(facts_.regions, kind, size.samples);
    if (seconds_.contains(kind)) {
      return {.seconds = size.samples * seconds_.at(kind).at(size.reach),
              .bytes = size.samples * bytes_.at(kind).at(size.reach)};
    }
    Load load = measured_load(middle_, kind, size.samples);
    load.seconds *= share_of_lights(task);
    return load;
  }

 private:
  [[nodiscard]] Law fit(const std::string& kind, double KindFigures::*figure) const {
    std::vector<std::pair<double, double>> points;
    for (const BakeFacts& facts : facts_.bakes) {
      points.emplace_back(static_cast<double>(facts.bake.sizes.size()),
                          facts.bake.kinds.at(kind).*figure);
    }
    return fit_law(points);
  }
  /// Dense LU of a channel: the cube of the unknowns, and a solution of their square.
  [[nodiscard]] Load solve(double reach) const {
    const KindFigures& figures = middle_.bake.kinds.at("solve");
    const double more = reach / static_cast<double>(middle_.bake.sizes.size());
    return {.seconds = figures.seconds * more * more * more, .bytes = figures.bytes * more * more};
  }
  [[nodiscard]] Load in_proportion(const std::string& kind, double samples) const {
    const KindFigures& figures = middle_.bake.kinds.at(kind);
    const double share = samples / middle_.bake.samples;
    Load load{.seconds = figures.seconds * share, .bytes = figures.bytes * share};
    if (makes_search(kind)) load.use_seconds = search_seconds(samples);
    return load;
  }
  [[nodiscard]] double search_seconds(double samples) const {
    return middle_.set_up.search_seconds * samples / middle_.bake.samples;
  }
  [[nodiscard]] Load window_functions(double samples) const {
    const MeasuredBake& bake = facts_.regions.bake;
    double windows = 0.0;
    for (const Region& region : bake.regions) windows += static_cast<double>(region.window.size());
    const double mean =
        bake.samples * windows / static_cast<double>(bake.regions.size() * bake.sizes.size());
    const KindFigures& figures = bake.kinds.at("window_functions");
    return {.seconds = figures.seconds * samples / mean, .bytes = figures.bytes * samples / mean};
  }
  /// 1 but for a light basis in a window: its example lights against those of a scene solved as a
  /// whole.
  [[nodiscard]] double share_of_lights(const TaskSpec& task) const {
    const auto& p = task.parameters;
    if (!p.contains("light_regions")) return 1.0;
    return p["lights"].get<double>() * static_cast<double>(p["light_regions"].size()) /
           middle_.bake.options.get<double>("lb.example_lights");
  }

  const CityFacts& facts_;
  const BakeFacts& middle_;
  std::map<std::string, Law> seconds_;
  std::map<std::string, Law> bytes_;
};

/// As many clusters as wanted, spread in size as those of the measured bake are.
std::vector<double> city_sizes(const MeasuredBake& bake, std::size_t clusters) {
  std::vector<double> sizes;
  const double mean = bake.samples / static_cast<double>(bake.sizes.size());
  for (std::size_t c = 0; c < clusters; ++c) {
    sizes.push_back(bake.sizes[c % bake.sizes.size()] * kCitySamplesPerCluster / mean);
  }
  return sizes;
}

void change_settings(GraphSettings& settings, const Change& change) {
  settings.parts = change.parts;
  if (!change.even_clusters) return;
  const double sum = std::accumulate(settings.sizes.begin(), settings.sizes.end(), 0.0);
  std::ranges::fill(settings.sizes, sum / static_cast<double>(settings.sizes.size()));
}

void change_machine(Machine& machine, const Change& change) {
  machine.total_bandwidth *= change.bandwidth_share;
  machine.poll *= change.poll_share;
  machine.scene_seconds *= change.scene_share;
  machine.first_task_seconds *= change.scene_share;
  machine.assembly.growing *= change.package_share;
  if (change.forgets) machine.cache_bytes = 0.0;
}

void change_loads(BakeGraph& graph, const GraphSettings& settings, const Change& change) {
  const std::size_t clusters = settings.sizes.size();
  const std::vector<std::size_t> region_of = regions_of_clusters(settings.regions, clusters);
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    const TaskSpec& task = graph.tasks[i];
    Load& load = graph.loads[i];
    load.is_kept = change.keeps_rays && task.kind == "rays";
    load.use_seconds *= change.search_share;
    if (settings.regions.empty()) continue;
    if (change.search_whole) continue;  // else what a window's rays hit
    const auto& p = task.parameters;
    std::size_t region = i % settings.regions.size();
    const auto cluster = cluster_of(task);
    if (p.contains("region")) region = p["region"].get<std::size_t>();
    if (cluster) region = region_of.at(*cluster);
    load.search_part = region;
    load.search_share =
        static_cast<double>(settings.regions[region].window.size()) / static_cast<double>(clusters);
  }
}

Machine machine_of(const BakeFacts& facts) {
  Machine machine;
  machine.scene_seconds = 0.5e-6 * facts.set_up.triangles + 0.05;
  machine.first_task_seconds = facts.set_up.caster_seconds;
  const MeasuredBake& bake = facts.bake;
  machine.assembly = {bake.outside_tasks - bake.package_seconds,
                      bake.package_seconds / bake.package_bytes};
  return machine;
}

Workload make_workload(const std::string& name, GraphSettings settings, Machine machine,
                       const Cost& cost, const Change& change) {
  change_settings(settings, change);
  change_machine(machine, change);
  Workload workload{name, make_lb_graph(settings, cost), machine};
  change_loads(workload.graph, settings, change);
  return workload;
}

}  // namespace

BakeFacts read_facts(const std::string& folder) {
  const std::filesystem::path path(folder);
  return {read_bake(path), measure_set_up(path / (path.filename().string() + ".prt.glb"))};
}

Workload measured_workload(const std::string& name, const BakeFacts& facts, const Change& change) {
  const Cost cost = [&](const TaskSpec& task, const TaskSize& size) {
    return measured_load(facts, task.kind, size.samples);
  };
  Workload workload = make_workload(name, measured_settings(facts.bake, facts.set_up.area),
                                    machine_of(facts), cost, change);
  workload.graph.package_bytes = facts.bake.package_bytes;
  return workload;
}

Workload replayed_workload(const BakeFacts& facts) {
  const MeasuredBake& bake = facts.bake;
  Workload workload{"replay", {}, ideal_machine(bake.ranks)};
  workload.machine.poll = Machine{}.poll;
  workload.machine.charge_coordinator = true;
  workload.graph =
      make_lb_graph(measured_settings(bake, facts.set_up.area), [](auto&&...) { return Load{}; });
  for (std::size_t i = 0; i < workload.graph.tasks.size(); ++i) {
    const std::string& id = workload.graph.tasks[i].id;
    const auto took = bake.task_seconds.find(id);
    if (took == bake.task_seconds.end()) {
      throw std::runtime_error(id + " is planned, yet the bake has no such task");
    }
    workload.graph.loads[i].seconds = took->second;
  }
  for (const auto& [id, seconds] : bake.task_seconds) {
    if (workload.graph.index.contains(id)) continue;
    throw std::runtime_error(id + " is in the bake, yet not planned for one round of snapshots");
  }
  return workload;
}

CityPlan plan_city(std::size_t clusters, std::size_t window) {
  CityPlan plan;
  plan.clusters = clusters;
  if (clusters <= lb::kWholeClusters) return plan;
  const Grid grid{clusters};
  const ClusterExchange exchange = city_exchange(grid);
  for (std::size_t c = 0; c < clusters; ++c) {
    plan.centres.emplace_back(static_cast<float>(grid.x(c)), static_cast<float>(grid.y(c)), 0.0F);
  }
  const auto n = static_cast<Eigen::Index>(clusters);
  plan.windows_seconds = timed([&] {
    const VectorD albedo = VectorD::Constant(n, 0.5);
    plan.regions = find_windows(make_regions(plan.centres, lb::kRegionClusters), exchange, albedo,
                                VectorD::Ones(n), uniform_irradiance(exchange, albedo),
                                {.most_clusters = window});
  });
  return plan;
}

Workload city_workload(const CityFacts& facts, const CityPlan& plan, const Change& change) {
  const GrowthLaws laws(facts);
  const BakeFacts& middle = facts.bakes.at(facts.bakes.size() / 2);
  const double samples = kCitySamplesPerCluster * static_cast<double>(plan.clusters);
  const double more = samples / middle.bake.samples;
  GraphSettings settings = measured_settings(middle.bake, more * middle.set_up.area);
  settings.options.set("samples.count", static_cast<std::size_t>(samples));
  settings.sizes = city_sizes(middle.bake, plan.clusters);
  settings.regions = plan.regions;
  settings.centres = plan.centres;
  Machine machine = machine_of(middle);
  const double triangles = kCityTrianglesPerSample * samples;
  machine.scene_seconds = 0.5e-6 * triangles;
  machine.first_task_seconds = middle.set_up.caster_seconds * triangles / middle.set_up.triangles;
  const Cost cost = [&](const TaskSpec& task, const TaskSize& size) {
    if (task.kind == "windows") return Load{.seconds = plan.windows_seconds};
    return laws.at(task, size);
  };
  Workload workload = make_workload(change.name, std::move(settings), machine, cost, change);
  workload.graph.package_bytes = middle.bake.package_bytes * more;
  return workload;
}

std::map<std::string, double> seconds_by_kind(const BakeGraph& graph) {
  std::map<std::string, double> seconds;
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    seconds[graph.tasks[i].kind] += graph.loads[i].seconds;
  }
  return seconds;
}

}  // namespace prt::scaling
