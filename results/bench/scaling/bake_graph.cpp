#include "scaling/bake_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace prt::scaling {

namespace {

using Ids = std::vector<std::string>;

constexpr std::size_t kReferences = 8;
constexpr std::size_t kLightTasks = 4;

std::string numbered(const std::string& stage, std::size_t i) {
  return fmt::format("{}/{:04}", stage, i);
}

Ids join(std::initializer_list<Ids> lists) {
  Ids all;
  for (const Ids& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

/// Seconds by which plan.cpp, sampling.cpp, rays.cpp and bake_evaluation.cpp order the tasks: not
/// what the tasks take.
double planned_cost(const std::string& kind, double samples) {
  static const std::map<std::string, double> kPerSample = {
      {"rays", 2e-7 * 2016}, {"visibility", 2e-4}, {"light_basis", 1.5e-4}, {"near", 5e-5},
      {"snapshot", 3e-4},    {"galerkin", 3e-4},   {"transfer", 6e-4},      {"residual", 5e-5}};
  static const std::map<std::string, double> kFixed = {
      {"start", 0.2}, {"candidates", 0.4}, {"cells", 0.4}, {"reference", 3e-6 * 2 * 1000 * 64}};
  if (const auto found = kPerSample.find(kind); found != kPerSample.end()) {
    return found->second * samples;
  }
  const auto found = kFixed.find(kind);
  return found == kFixed.end() ? 1.0 : found->second;
}

/// The graph, stage by stage. With one tile its ids, inputs and order of planning are those of the
/// real planner; parameters are the cluster's number alone, as keys need no more here.
class Builder {
 public:
  Builder(const GraphSettings& settings, const Cost& cost) : s_(settings), cost_(cost) {}

  BakeGraph build() {
    plan_points();
    plan_samples();
    for (std::size_t t = 0; t < s_.tiles; ++t) plan_direct(t);
    for (std::size_t t = 0; t < s_.tiles; ++t) plan_snapshots(t);
    for (std::size_t t = 0; t < s_.tiles; ++t) plan_galerkin(t);
    plan_solve();
    for (std::size_t t = 0; t < s_.tiles; ++t) plan_transfer(t);
    for (std::size_t t = 0; t < s_.tiles; ++t) plan_residual(t);
    graph_.end_plan();
    for (std::size_t t = 0; t < s_.tiles; ++t) plan_evaluation(t);
    graph_.end_plan();
    return std::move(graph_);
  }

 private:
  // ---- tiles ------------------------------------------------------------------------------------

  [[nodiscard]] std::size_t first(std::size_t tile) const {
    return tile * s_.sizes.size() / s_.tiles;
  }
  [[nodiscard]] std::size_t clusters(std::size_t tile) const {
    return first(tile + 1) - first(tile);
  }
  [[nodiscard]] double samples(std::size_t tile) const {
    return std::accumulate(s_.sizes.begin() + static_cast<std::ptrdiff_t>(first(tile)),
                           s_.sizes.begin() + static_cast<std::ptrdiff_t>(first(tile + 1)), 0.0);
  }
  /// Tiles that a tile exchanges light with: its neighbours along a row, and itself.
  [[nodiscard]] std::vector<std::size_t> near_tiles(std::size_t tile) const {
    std::vector<std::size_t> near;
    for (std::size_t t = tile == 0 ? 0 : tile - 1; t < std::min(s_.tiles, tile + 2); ++t) {
      near.push_back(t);
    }
    return near;
  }
  [[nodiscard]] double reach(std::size_t tile) const {
    double count = 0.0;
    for (const std::size_t t : near_tiles(tile)) count += static_cast<double>(clusters(t));
    return count;
  }
  /// Name of what there is once per tile: "samples", and with several tiles "samples-0007".
  [[nodiscard]] std::string of_tile(const std::string& stage, std::size_t tile) const {
    return s_.tiles == 1 ? stage : fmt::format("{}-{:04}", stage, tile);
  }
  [[nodiscard]] Ids of_near_tiles(const std::string& stage, std::size_t tile) const {
    Ids ids;
    for (const std::size_t t : near_tiles(tile)) ids.push_back(of_tile(stage, t));
    return ids;
  }
  [[nodiscard]] Ids of_clusters(const std::string& stage, std::size_t tile) const {
    Ids ids;
    for (std::size_t c = first(tile); c < first(tile + 1); ++c) ids.push_back(numbered(stage, c));
    return ids;
  }

  // ---- tasks ------------------------------------------------------------------------------------

  void add(const std::string& kind, const std::string& id, Ids inputs, const Load& load,
           double samples = 1.0, std::string place = {}) {
    TaskSpec spec;
    spec.place = std::move(place);
    spec.id = id;
    spec.kind = kind;
    spec.inputs = std::move(inputs);
    spec.parameters["cluster"] = graph_.tasks.size();
    spec.scene_parts = kGeometry;
    spec.cost = planned_cost(kind, samples);
    graph_.add(std::move(spec), load);
  }
  /// One task per cluster of a tile; `inputs(c)` lists its inputs.
  template <typename Inputs>
  void per_cluster(const std::string& kind, std::size_t tile, Inputs&& inputs) {
    for (std::size_t c = first(tile); c < first(tile + 1); ++c) {
      add(kind, numbered(kind, c), inputs(c), cost_(kind, s_.sizes[c], reach(tile)), s_.sizes[c],
          numbered(s_.tiles == 1 ? "cluster" : "tile", s_.tiles == 1 ? c : tile));
    }
  }
  void whole_tile(const std::string& kind, std::size_t tile, Ids inputs) {
    Load load = cost_(kind, samples(tile), reach(tile));
    load.use_group = tile;
    add(kind, of_tile(kind, tile), std::move(inputs), load);
  }
  /// Names for what all clusters of the near tiles made: the list itself, one gate, or a bundle per
  /// tile, which is a task like any other.
  Ids all_of(const std::string& kind, std::size_t tile) {
    if (!s_.gates && s_.tiles == 1) return of_clusters(kind, tile);
    return of_near_tiles(kind + "_all", tile);
  }
  void collect(const std::string& kind, std::size_t tile) {
    if (!s_.gates && s_.tiles == 1) return;
    const Ids parts = of_clusters(kind, tile);
    Load load = s_.tiles > 1 ? cost_("snapshot_functions", samples(tile), reach(tile)) : Load{};
    load.bytes = 0.0;
    for (const std::string& id : parts) load.bytes += graph_.loads[graph_.index.at(id)].bytes;
    if (s_.tiles == 1) {
      load.is_written = false;
      load.files = static_cast<double>(parts.size());
    }
    add(kind + "_all", of_tile(kind + "_all", tile), parts, load);
  }
  /// Charges the inputs that a gate hides to the task that was just added.
  void stand_for(std::size_t tile) {
    if (!s_.gates || s_.tiles > 1) return;
    for (std::size_t i = graph_.loads.size() - clusters(tile); i < graph_.loads.size(); ++i) {
      graph_.loads[i].stands_for = static_cast<double>(clusters(tile));
    }
  }

  // ---- stages (sampling.cpp) --------------------------------------------------------------------

  void plan_points() {
    add("start", "start", {}, cost_("start", 1.0, 1.0));
    for (std::size_t t = 0; t < s_.tiles; ++t) {
      Ids candidates;
      for (double i = 0; i < s_.candidate_tasks; ++i) {
        candidates.push_back(numbered(of_tile("candidates", t), candidates.size()));
        add("candidates", candidates.back(), {"start"}, cost_("candidates", 1.0, 1.0));
      }
      whole_tile("points", t, candidates);
    }
    graph_.end_plan();
  }

  void plan_samples() {
    for (std::size_t t = 0; t < s_.tiles; ++t) {
      Ids inputs = {of_tile("points", t)};
      for (double i = 0; i < s_.cell_tasks; ++i) {
        const std::string id = numbered(of_tile("cells", t), inputs.size() - 1);
        add("cells", id, of_near_tiles("points", t), cost_("cells", 1.0, 1.0));
        inputs.push_back(id);
      }
      whole_tile("samples", t, inputs);
      whole_tile("albedo", t, inputs);
    }
    for (std::size_t k = 0; k < kReferences; ++k) {
      add("reference", numbered("reference", k), {of_tile("samples", k % s_.tiles)},
          cost_("reference", 1.0, 1.0));
    }
    graph_.end_plan();
  }

  // ---- stages (rays.cpp, plan.cpp) --------------------------------------------------------------

  [[nodiscard]] Ids surface(std::size_t tile) const {
    return join({of_near_tiles("samples", tile), of_near_tiles("albedo", tile)});
  }

  void plan_direct(std::size_t t) {
    const Ids samples = of_near_tiles("samples", t);
    per_cluster("rays", t, [&](std::size_t) { return samples; });
    per_cluster("visibility", t, [](std::size_t c) { return Ids{numbered("rays", c)}; });
    Ids lights;
    for (std::size_t i = 0; i < kLightTasks; ++i) {
      lights.push_back(numbered(of_tile("lights", t), i));
      add("lights", lights.back(), {of_tile("samples", t)}, cost_("lights", 1.0, 1.0));
    }
    per_cluster("light_basis", t, [&](std::size_t c) {
      return join({surface(t), {numbered("rays", c)}, lights});
    });
    whole_tile("light_functions", t,
               join({{of_tile("samples", t)}, of_clusters("light_basis", t)}));
    per_cluster("near", t, [&](std::size_t c) { return join({samples, {numbered("rays", c)}}); });
    collect("near", t);
  }

  [[nodiscard]] Ids gather_inputs(std::size_t t, std::size_t c, const std::string& functions) {
    return join({surface(t), {numbered("rays", c)}, of_near_tiles(functions, t)});
  }

  void plan_snapshots(std::size_t t) {
    per_cluster("snapshot", t,
                [&](std::size_t c) { return gather_inputs(t, c, "light_functions"); });
    whole_tile("snapshot_functions", t,
               join({{of_tile("samples", t)}, of_clusters("snapshot", t)}));
  }

  void plan_galerkin(std::size_t t) {
    per_cluster("galerkin", t,
                [&](std::size_t c) { return gather_inputs(t, c, "snapshot_functions"); });
  }

  [[nodiscard]] std::size_t solve_tasks() const { return s_.channels * s_.solve_parts; }
  [[nodiscard]] std::string solve_name(std::size_t sweep, std::size_t task) const {
    return numbered(s_.sweeps == 1 ? "solve" : fmt::format("solve-{}", sweep), task);
  }

  /// Today one task per channel solves for the whole scene. Tile by tile, every sweep reads what
  /// the last one made of the near tiles; a tile's rows may be shared out to several tasks.
  void plan_solve() {
    for (std::size_t sweep = 0; sweep < s_.sweeps; ++sweep) {
      for (std::size_t t = 0; t < s_.tiles; ++t) {
        for (std::size_t task = 0; task < solve_tasks(); ++task) {
          Load load = cost_("solve", samples(t), static_cast<double>(clusters(t)));
          load.seconds /= static_cast<double>(s_.solve_parts);
          load.bytes /= static_cast<double>(s_.solve_parts);
          const Ids before = sweep > 0 ? solved(sweep - 1, t, task % s_.channels) : Ids{};
          add("solve", of_tile(solve_name(sweep, task), t),
              join({solve_rows(t, task / s_.channels), before}), load);
        }
      }
    }
  }
  /// What a sweep made of one channel on the near tiles.
  [[nodiscard]] Ids solved(std::size_t sweep, std::size_t t, std::size_t channel) const {
    Ids ids;
    for (std::size_t part = 0; part < s_.solve_parts; ++part) {
      const std::size_t task = part * s_.channels + channel;
      ids = join({ids, of_near_tiles(solve_name(sweep, task), t)});
    }
    return ids;
  }
  /// What part `part` of a tile's solve reads: the snapshots and rows of its share of the clusters.
  [[nodiscard]] Ids solve_rows(std::size_t t, std::size_t part) const {
    Ids rows;
    for (const std::string kind : {"snapshot", "galerkin"}) {
      const Ids all = of_clusters(kind, t);
      const auto at = [&](std::size_t p) {
        return all.begin() + static_cast<std::ptrdiff_t>(p * all.size() / s_.solve_parts);
      };
      rows.insert(rows.end(), at(part), at(part + 1));
    }
    return rows;
  }

  void plan_transfer(std::size_t t) {
    Ids bounces = of_near_tiles("snapshot_functions", t);
    for (std::size_t channel = 0; channel < s_.channels; ++channel) {
      bounces = join({bounces, solved(s_.sweeps - 1, t, channel)});
    }
    const Ids near = all_of("near", t);
    per_cluster("transfer", t, [&](std::size_t c) {
      return join({gather_inputs(t, c, "light_functions"), near, bounces});
    });
    stand_for(t);
    collect("transfer", t);
  }

  void plan_residual(std::size_t t) {
    const Ids transfer = all_of("transfer", t);
    per_cluster("residual", t, [&](std::size_t c) {
      return join({surface(t), {numbered("rays", c)}, transfer});
    });
    stand_for(t);
  }

  void plan_evaluation(std::size_t t) {
    Ids inputs;
    for (std::size_t k = 0; k < kReferences; ++k) inputs.push_back(numbered("reference", k));
    for (const std::string kind : {"visibility", "near", "transfer"}) {
      inputs = join({inputs, of_clusters(kind, t)});
    }
    whole_tile("evaluate", t, join({inputs, surface(t), of_near_tiles("light_functions", t)}));
  }

  const GraphSettings& s_;
  const Cost& cost_;
  BakeGraph graph_;
};

}  // namespace

void BakeGraph::add(TaskSpec spec, const Load& load) {
  index[spec.id] = tasks.size();
  std::vector<std::size_t>& in = inputs.emplace_back();
  for (const std::string& id : spec.inputs) in.push_back(index.at(id));
  tasks.push_back(std::move(spec));
  loads.push_back(load);
}

double BakeGraph::work() const {
  return std::accumulate(loads.begin(), loads.end(), 0.0,
                         [](double sum, const Load& load) { return sum + load.seconds; });
}

std::map<std::string, double> longest_chain(const BakeGraph& graph) {
  constexpr auto kNobody = static_cast<std::size_t>(-1);
  std::vector<double> end(graph.tasks.size(), 0.0);
  std::vector<std::size_t> before(graph.tasks.size(), kNobody);
  std::size_t latest = kNobody;      // of all tasks so far
  std::size_t planned_by = kNobody;  // the last task of the plan before
  auto plan = graph.plans.begin();
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    while (plan != graph.plans.end() && i == *plan) {
      planned_by = latest;
      ++plan;
    }
    before[i] = planned_by;
    for (const std::size_t input : graph.inputs[i]) {
      if (before[i] == kNobody || end[input] > end[before[i]]) before[i] = input;
    }
    end[i] = graph.loads[i].seconds + (before[i] == kNobody ? 0.0 : end[before[i]]);
    if (latest == kNobody || end[i] > end[latest]) latest = i;
  }
  std::map<std::string, double> chain;
  for (std::size_t i = latest; i != kNobody; i = before[i]) {
    chain[graph.tasks[i].kind] += graph.loads[i].seconds;
  }
  return chain;
}

BakeGraph make_lb_graph(const GraphSettings& settings, const Cost& cost) {
  return Builder(settings, cost).build();
}

}  // namespace prt::scaling
