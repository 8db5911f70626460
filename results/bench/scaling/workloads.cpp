#include "scaling/workloads.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>

namespace prt::scaling {

namespace {

constexpr double kCitySamplesPerCluster = 1000.0;
constexpr double kCandidatesPerTask = 100000.0 / 24.0;  // samples: sampling.cpp, 24 candidates each
constexpr double kSamplesPerCellTask = 200000.0 / 32.0;
constexpr double kMostCellTasks = 300.0;  // kMostPoints / kPointsPerTask
// Triangles of the city per sample: a street scene's, as sponza has.
constexpr double kCityTrianglesPerSample = 2.0;

/// Work and bytes of a kind grow with the clusters that a result refers to, to this power: from the
/// code (gather_functions, transfer's product with the reduced solution, files of reduced rows).
int seconds_power(const std::string& kind) { return kind == "transfer" ? 2 : 1; }

bool is_whole_scene(const std::string& kind) {
  static const std::set<std::string> kKinds = {
      "points", "samples", "albedo", "light_functions", "snapshot_functions", "evaluate"};
  return kKinds.contains(kind);
}

bool makes_search(const std::string& kind) { return kind == "points" || kind == "samples"; }

/// What a measured bake's tasks took, with all clusters within reach.
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

Load changed(Load load, const std::string& kind, const Change& change) {
  if (kind == "points" || kind == "solve" || kind == "evaluate") {
    load.seconds /= change.serial_parts;
  }
  load.use_seconds *= change.search_share;
  return load;
}

/// Reading what is kept costs nothing; it is still written.
void keep(BakeGraph& graph, const Change& change) {
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    graph.loads[i].is_kept =
        change.keeps_inputs || (change.keeps_rays && graph.tasks[i].kind == "rays");
  }
}

Machine machine_of(const BakeFacts& facts, const Change& change) {
  Machine machine;
  machine.scene_seconds = 0.5e-6 * facts.set_up.triangles + 0.05;
  machine.first_task_seconds = facts.set_up.caster_seconds;
  machine.assembly_per_byte = facts.bake.outside_tasks / facts.bake.package_bytes;
  machine.total_bandwidth *= change.bandwidth_share;
  machine.poll *= change.poll_share;
  return machine;
}

/// Laws by kind, fitted once.
class GrowthLaws {
 public:
  explicit GrowthLaws(const CityFacts& facts)
      : facts_(facts), middle_(facts.bakes.at(facts.bakes.size() / 2)) {
    for (const auto& [kind, figures] : middle_.bake.kinds) {
      if (figures.seconds_per_sample <= 0.0) continue;
      seconds_[kind] = fit(kind, &KindFigures::seconds_per_sample, seconds_power(kind));
      bytes_[kind] = fit(kind, &KindFigures::bytes_per_sample, 1);
    }
  }

  [[nodiscard]] Load at(const std::string& kind, double samples, double reach) const {
    if (kind == "solve") return solve(reach);
    if (is_whole_scene(kind)) return whole_scene(kind, samples);
    const KindFigures& figures = middle_.bake.kinds.at(kind);
    if (!seconds_.contains(kind)) return {.seconds = figures.seconds, .bytes = figures.bytes};
    return {.seconds = samples * seconds_.at(kind).at(reach),
            .bytes = samples * bytes_.at(kind).at(reach)};
  }

 private:
  [[nodiscard]] Law fit(const std::string& kind, double KindFigures::*figure, int power) const {
    std::vector<std::pair<double, double>> points;
    for (const BakeFacts& facts : facts_.bakes) {
      points.emplace_back(static_cast<double>(facts.bake.sizes.size()),
                          facts.bake.kinds.at(kind).*figure);
    }
    return fit_law(points, power);
  }
  /// Dense LU of a channel: the cube of the unknowns, and a solution of their square.
  [[nodiscard]] Load solve(double reach) const {
    const KindFigures& figures = middle_.bake.kinds.at("solve");
    const double more = reach / static_cast<double>(middle_.bake.sizes.size());
    return {.seconds = figures.seconds * more * more * more, .bytes = figures.bytes * more * more};
  }
  /// In proportion to the samples (points a little worse: it sorts).
  [[nodiscard]] Load whole_scene(const std::string& kind, double samples) const {
    const KindFigures& figures = middle_.bake.kinds.at(kind);
    const double share = samples / middle_.bake.samples;
    Load load{.seconds = figures.seconds * share, .bytes = figures.bytes * share};
    if (makes_search(kind)) load.use_seconds = middle_.set_up.search_seconds * share;
    return load;
  }

  const CityFacts& facts_;
  const BakeFacts& middle_;
  std::map<std::string, Law> seconds_;
  std::map<std::string, Law> bytes_;
};

/// As many clusters as wanted, spread in size as those of the measured bake are.
std::vector<double> city_sizes(const MeasuredBake& bake, std::size_t clusters, bool even) {
  std::vector<double> sizes;
  const double mean = bake.samples / static_cast<double>(bake.sizes.size());
  for (std::size_t c = 0; c < clusters; ++c) {
    const double size = even ? mean : bake.sizes[c % bake.sizes.size()];
    sizes.push_back(size * kCitySamplesPerCluster / mean);
  }
  return sizes;
}

Machine city_machine(const BakeFacts& facts, double samples, const Change& change) {
  Machine machine = machine_of(facts, change);
  const double triangles = kCityTrianglesPerSample * samples;
  const double more = triangles / facts.set_up.triangles;
  machine.scene_seconds = 0.5e-6 * triangles;
  machine.first_task_seconds = facts.set_up.caster_seconds * more;
  machine.scene_seconds *= change.scene_share;
  machine.first_task_seconds *= change.scene_share;
  return machine;
}

}  // namespace

BakeFacts read_facts(const std::string& folder) {
  const std::filesystem::path path(folder);
  return {read_bake(path), measure_set_up(path / (path.filename().string() + ".prt.glb"))};
}

Workload measured_workload(const std::string& name, const BakeFacts& facts, const Change& change) {
  GraphSettings settings;
  settings.sizes = facts.bake.sizes;
  if (change.even_clusters) {
    const double mean = facts.bake.samples / static_cast<double>(settings.sizes.size());
    std::ranges::fill(settings.sizes, mean);
  }
  settings.candidate_tasks = static_cast<double>(facts.bake.kinds.at("candidates").tasks);
  settings.cell_tasks = static_cast<double>(facts.bake.kinds.at("cells").tasks);
  settings.channels = facts.bake.kinds.at("solve").tasks;
  Workload workload{name, {}, machine_of(facts, change)};
  workload.graph = make_lb_graph(settings, [&](const std::string& kind, double samples, double) {
    return changed(measured_load(facts, kind, samples), kind, change);
  });
  workload.graph.package_bytes = facts.bake.package_bytes;
  keep(workload.graph, change);
  return workload;
}

Workload replayed_workload(const MeasuredBake& bake) {
  GraphSettings settings;
  settings.sizes = bake.sizes;
  settings.candidate_tasks = static_cast<double>(bake.kinds.at("candidates").tasks);
  settings.cell_tasks = static_cast<double>(bake.kinds.at("cells").tasks);
  settings.channels = bake.kinds.at("solve").tasks;
  Workload workload{"replay", {}, ideal_machine(bake.ranks)};
  workload.machine.poll = Machine{}.poll;
  workload.machine.charge_coordinator = true;
  workload.graph = make_lb_graph(settings, [](auto&&...) { return Load{}; });
  for (std::size_t i = 0; i < workload.graph.tasks.size(); ++i) {
    const auto took = bake.task_seconds.find(workload.graph.tasks[i].id);
    if (took == bake.task_seconds.end() ||
        bake.task_seconds.size() != workload.graph.tasks.size()) {
      throw std::runtime_error("this bake has other tasks than one round of snapshots makes");
    }
    workload.graph.loads[i].seconds = took->second;
  }
  return workload;
}

Workload city_today(const CityFacts& facts, std::size_t clusters) {
  const GrowthLaws laws(facts);
  const BakeFacts& middle = facts.bakes.at(facts.bakes.size() / 2);
  GraphSettings settings;
  settings.sizes = city_sizes(middle.bake, clusters, false);
  settings.gates = true;
  const double samples = kCitySamplesPerCluster * static_cast<double>(clusters);
  settings.candidate_tasks = std::ceil(samples / kCandidatesPerTask);
  settings.cell_tasks = std::min(kMostCellTasks, std::ceil(samples / kSamplesPerCellTask));
  Workload workload{"city-today", {}, city_machine(middle, samples, {})};
  workload.machine.edge_seconds = facts.edge_seconds;
  workload.graph = make_lb_graph(settings, [&](const std::string& kind, double n, double reach) {
    return laws.at(kind, n, reach);
  });
  workload.graph.package_bytes = middle.bake.package_bytes * samples / middle.bake.samples;
  return workload;
}

Workload city_in_tiles(const CityFacts& facts, std::size_t clusters, const Change& change) {
  const GrowthLaws laws(facts);
  const BakeFacts& middle = facts.bakes.at(facts.bakes.size() / 2);
  GraphSettings settings;
  settings.sizes = city_sizes(middle.bake, clusters, change.even_clusters);
  settings.tiles = clusters / middle.bake.sizes.size();
  settings.sweeps = 8;
  settings.solve_parts = static_cast<std::size_t>(change.serial_parts);
  const double samples = kCitySamplesPerCluster * static_cast<double>(clusters);
  const auto per_tile = [&](double tasks) {
    return std::ceil(tasks / static_cast<double>(settings.tiles));
  };
  settings.candidate_tasks = per_tile(samples / kCandidatesPerTask);
  settings.cell_tasks = per_tile(samples / kSamplesPerCellTask);
  Workload workload{change.name, {}, city_machine(middle, samples, change)};
  workload.graph = make_lb_graph(settings, [&](const std::string& kind, double n, double reach) {
    Load load = laws.at(kind, n, reach);
    // The graph itself splits the solve.
    return kind == "solve" ? load : changed(load, kind, change);
  });
  workload.graph.package_bytes = middle.bake.package_bytes * samples / middle.bake.samples;
  // Tiles of the package are written side by side; what is left is the scene and the index.
  workload.machine.assembly_per_byte /= static_cast<double>(settings.tiles);
  keep(workload.graph, change);
  if (change.ignores_places) {
    for (TaskSpec& task : workload.graph.tasks) task.place.clear();
  }
  return workload;
}

std::map<std::string, double> seconds_by_kind(const BakeGraph& graph) {
  std::map<std::string, double> seconds;
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    seconds[graph.tasks[i].kind] += graph.loads[i].seconds;
  }
  return seconds;
}

double measure_edge_seconds(const BakeFacts& facts, std::size_t clusters) {
  GraphSettings settings;
  settings.sizes.assign(clusters, kCitySamplesPerCluster);
  const BakeGraph graph = make_lb_graph(settings, [&](const std::string& kind, double n, double) {
    return measured_load(facts, kind, n);
  });
  Machine machine = ideal_machine(64);
  machine.charge_coordinator = true;
  const Outcome outcome = simulate(graph, machine);
  double edges = 0.0;
  for (const auto& inputs : graph.inputs) edges += static_cast<double>(inputs.size());
  return outcome.coordinator / edges;
}

}  // namespace prt::scaling
