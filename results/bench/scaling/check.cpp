#include "scaling/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

/// A bake's graph lies between the bounds that hold for every list schedule (Graham 1966).
void check_bounds(Checker& checker) {
  GraphSettings settings;
  settings.sizes = {500, 1500, 800, 1200, 1000, 900, 1100, 1000};
  const Cost cost = [](const std::string&, double samples, double) {
    return Load{.seconds = 1e-3 * samples};
  };
  for (const std::size_t tiles : {1, 4}) {
    settings.tiles = tiles;
    const BakeGraph graph = make_lb_graph(settings, cost);
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

}  // namespace

int check_simulation() {
  Checker checker;
  check_independent(checker);
  check_chain(checker);
  check_plans(checker);
  check_disk(checker);
  check_bounds(checker);
  return checker.wrong();
}

}  // namespace prt::scaling
