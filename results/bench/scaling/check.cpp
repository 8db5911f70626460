#include "scaling/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "methods/lb/lb.h"
#include "scaling/shared_disk.h"
#include "scaling/simulation.h"

namespace prt::scaling {

namespace {

// Times are sums of a few thousand doubles.
constexpr double kRounding = 1e-9;

class Checker {
 public:
  void expect(bool holds, const std::string& what) {
    if (holds) return;
    fmt::print(stderr, "simulate_scaling --check: {}\n", what);
    ++wrong_;
  }
  void expect_near(double value, double wanted, const std::string& what) {
    expect(std::abs(value - wanted) <= kRounding * std::max(1.0, std::abs(wanted)),
           fmt::format("{}: {} instead of {}", what, value, wanted));
  }
  [[nodiscard]] int wrong() const { return wrong_; }

 private:
  int wrong_ = 0;
};

void add(BakeGraph& graph, const std::string& id, std::vector<std::string> inputs,
         const Load& load) {
  TaskSpec spec;
  spec.id = id;
  spec.kind = "task";
  spec.inputs = std::move(inputs);
  spec.parameters["name"] = id;
  spec.cost = load.seconds;
  graph.add(std::move(spec), load);
}

BakeGraph equal_tasks(std::size_t count, const Load& load) {
  BakeGraph graph;
  for (std::size_t i = 0; i < count; ++i) add(graph, std::to_string(i), {}, load);
  graph.end_plan();
  return graph;
}

void check_independent(Checker& checker) {
  constexpr std::size_t kTasks = 96;
  const BakeGraph graph = equal_tasks(kTasks, {.seconds = 2.0});
  for (const int ranks : {1, 2, 3, 32, 96, 500}) {
    const double most = std::ceil(static_cast<double>(kTasks) / ranks);
    const Outcome outcome = simulate(graph, ideal_machine(ranks));
    checker.expect_near(graph.work() / outcome.seconds, kTasks / most,
                        fmt::format("speed-up of independent tasks on {} ranks", ranks));
    checker.expect_near(outcome.busy, graph.work(), "work of independent tasks");
    checker.expect(outcome.completions == kTasks, "every task is done once");
  }
}

void check_chain(Checker& checker) {
  BakeGraph graph;
  add(graph, "0", {}, {.seconds = 1.5});
  for (int i = 1; i < 50; ++i) {
    add(graph, std::to_string(i), {std::to_string(i - 1)}, {.seconds = 1.5});
  }
  graph.end_plan();
  checker.expect_near(longest_chain(graph).at("task"), graph.work(), "length of a chain");
  for (const int ranks : {1, 7, 100}) {
    checker.expect_near(simulate(graph, ideal_machine(ranks)).seconds, graph.work(),
                        "time of a chain");
  }
}

/// Two plans: the second begins when the slowest task of the first is done.
void check_plans(Checker& checker) {
  BakeGraph graph = equal_tasks(4, {.seconds = 1.0});
  add(graph, "late", {}, {.seconds = 3.0});
  graph.end_plan();
  checker.expect_near(simulate(graph, ideal_machine(8)).seconds, 4.0, "time of two plans");
  checker.expect_near(longest_chain(graph).at("task"), 4.0, "chain through two plans");
}

/// Transfers share what there is in total, and none is faster than its rank.
void check_disk(Checker& checker) {
  SharedDisk disk(2.0, 3.0);
  disk.start(0, 6.0, 0.0);  // alone for a second at 2, then at 1.5
  disk.start(1, 1.5, 1.0);
  checker.expect_near(disk.next_end(), 2.0, "end of the short transfer");
  checker.expect(disk.finish_next() == 1, "the short transfer ends first");
  checker.expect_near(disk.next_end(), 3.25, "end of the long transfer");

  Machine machine = ideal_machine(4);
  machine.rank_bandwidth = machine.total_bandwidth = 10.0;
  const BakeGraph writers = equal_tasks(4, {.seconds = 1.0, .bytes = 5.0});
  checker.expect_near(simulate(writers, machine).seconds, 3.0, "four ranks write at once");
}

OptionValues default_options() {
  OptionValues options;
  for (const auto& table : {shared_options(), lb_method().options()}) {
    for (const OptionSpec& spec : table) options.set(spec.key, spec.fallback);
  }
  return options;
}

/// Eight clusters in one region, or two to a region in the window of their neighbours.
GraphSettings small_bake(bool in_regions) {
  GraphSettings settings;
  settings.options = default_options();
  settings.sizes = {500, 1500, 800, 1200, 1000, 900, 1100, 1000};
  if (!in_regions) return settings;
  settings.options.set("lb.region_clusters", 2);
  for (std::size_t c = 0; c < settings.sizes.size(); ++c) {
    settings.centres.emplace_back(static_cast<float>(c), 0.0F, 0.0F);
  }
  settings.regions = {{{0, 1}, {0, 1, 2, 3}, 0.0},
                      {{2, 3}, {0, 1, 2, 3, 4, 5}, 0.0},
                      {{4, 5}, {2, 3, 4, 5, 6, 7}, 0.0},
                      {{6, 7}, {4, 5, 6, 7}, 0.0}};
  return settings;
}

/// A bake's graph lies between the bounds that hold for every list schedule (Graham 1966).
void check_bounds(Checker& checker) {
  const Cost cost = [](const TaskSpec&, const TaskSize& size) {
    return Load{.seconds = 1e-3 * size.samples};
  };
  for (const bool in_regions : {false, true}) {
    const BakeGraph graph = make_lb_graph(small_bake(in_regions), cost);
    double chain = 0.0;
    for (const auto& [kind, seconds] : longest_chain(graph)) chain += seconds;
    for (const int ranks : {1, 3, 16, 1000}) {
      const Outcome outcome = simulate(graph, ideal_machine(ranks));
      const double share = graph.work() / ranks;
      checker.expect(outcome.seconds >= std::max(chain, share) * (1.0 - kRounding),
                     "no bake is shorter than its chain or its share of the work");
      // Plans only add to the chain: each begins when the longest of the one before has ended.
      checker.expect(outcome.seconds <= (chain + share) * (1.0 + kRounding),
                     "no rank is idle while a task is ready");
      checker.expect_near(outcome.busy, graph.work(), "work of a bake");
    }
  }
}

/// What a task of a region is about, and what it reads: its window alone.
void check_regions(Checker& checker) {
  std::map<std::string, TaskSize> sizes;
  const Cost cost = [&](const TaskSpec& task, const TaskSize& size) {
    sizes[task.id] = size;
    return Load{};
  };
  GraphSettings settings = small_bake(true);
  const BakeGraph graph = make_lb_graph(settings, cost);
  const auto inputs = [&](const std::string& id) {
    return static_cast<double>(graph.inputs[graph.index.at(id)].size());
  };
  checker.expect_near(sizes.at("solve/0000").reach, 4, "clusters of the first window");
  checker.expect_near(sizes.at("snapshot_functions/0001").samples, 5900, "samples of a window");
  checker.expect_near(sizes.at("region_functions/0001").samples, 2000, "samples of a region");
  checker.expect_near(sizes.at("transfer/0001").samples, 1500, "samples of a cluster");
  checker.expect_near(sizes.at("visibility/0001").samples, 1500, "samples of a cluster's rays");
  checker.expect_near(inputs("solve/0000"), 4 + 4 + 1, "inputs of a solve: the window, twice");
  checker.expect(!graph.index.contains("solve/0012"), "a solve per region and channel");

  settings.parts["solve"] = 3;
  const BakeGraph split = make_lb_graph(settings, cost);
  checker.expect_near(static_cast<double>(split.tasks.size() - graph.tasks.size()), 12 * 2,
                      "tasks more when each of 12 is split into three");
  const auto& readers = split.inputs[split.index.at("transfer/0000")];
  checker.expect_near(static_cast<double>(readers.size()), inputs("transfer/0000") + 3 * 2,
                      "inputs of who reads what is split");
}

/// A rank makes the neighbour search once, or the part of it that its tasks want.
void check_search(Checker& checker) {
  const auto seconds = [](std::size_t parts, double share) {
    BakeGraph graph;
    add(graph, "samples", {}, {.use_seconds = 8.0});
    for (std::size_t i = 0; i < 4; ++i) {
      add(graph, std::to_string(i), {"samples"},
          {.seconds = 1.0, .search_part = i % parts, .search_share = share});
      graph.tasks.back().kind = "rays";
    }
    graph.end_plan();
    return simulate(graph, ideal_machine(1)).seconds;
  };
  checker.expect_near(seconds(1, 1.0), 4.0 + 8.0, "one search");
  checker.expect_near(seconds(2, 0.25), 4.0 + 2 * 2.0, "two searches of a quarter each");
}

}  // namespace

int check_simulation() {
  Checker checker;
  check_independent(checker);
  check_chain(checker);
  check_plans(checker);
  check_disk(checker);
  check_bounds(checker);
  check_regions(checker);
  check_search(checker);
  return checker.wrong();
}

}  // namespace prt::scaling
