// Predicts how a bake scales over ranks: the real coordinator (src/jobs) hands out tasks to
// simulated ranks, with times and sizes measured in bakes of one rank and one thread.
//   simulate_scaling --gallery out/gallery22500 ... --sponza out/sponza --house out/house
//   simulate_scaling --check
// results/scaling.md says how the bakes are made.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <future>

#include "scaling/check.h"
#include "scaling/coordinator_speed.h"
#include "scaling/workloads.h"

namespace prt::scaling {
namespace {

constexpr std::size_t kCityClusters = 10'000;
constexpr int kMostRanks = 10'000;
constexpr std::size_t kWindow = 192;       // clusters: the most that plan.cpp allows
constexpr std::size_t kSmallWindow = 141;  // what a window might be where less is seen

struct Options {
  std::vector<std::string> galleries;
  std::string sponza;
  std::string house;
  std::string replay;
  std::string csv = "results/scaling.csv";
  bool check = false;
};

std::vector<int> rank_counts(std::size_t tasks) {
  std::vector<int> counts;
  for (int ranks = 1; ranks < kMostRanks; ranks *= 2) {
    counts.push_back(ranks);
    if (static_cast<std::size_t>(ranks) > tasks) return counts;  // more change nothing
    if (ranks == 64) counts.push_back(100);
    if (ranks == 512) counts.push_back(1000);
  }
  counts.push_back(kMostRanks);
  return counts;
}

struct Row {
  int ranks;
  double speed_up;
  Outcome outcome;
};

double chain_seconds(const BakeGraph& graph) {
  double sum = 0.0;
  for (const auto& [kind, seconds] : longest_chain(graph)) sum += seconds;
  return sum;
}

/// Simulates a workload on several numbers of ranks, side by side: the clock is each thread's own.
/// Speed-ups are against `one` seconds; 0: against the first.
std::vector<Row> sweep(const Workload& workload, const std::vector<int>& counts, double one) {
  std::vector<std::future<Outcome>> outcomes;
  for (const int ranks : counts) {
    outcomes.push_back(std::async(std::launch::async, [&workload, ranks] {
      Machine machine = workload.machine;
      machine.ranks = ranks;
      return simulate(workload.graph, machine);
    }));
  }
  std::vector<Row> rows;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Outcome outcome = outcomes[i].get();
    if (one <= 0.0) one = outcome.seconds;
    rows.push_back({counts[i], one / outcome.seconds, outcome});
  }
  return rows;
}

/// The kinds of task that a sum of seconds is mostly made of.
std::string shares(const std::map<std::string, double>& seconds) {
  std::vector<std::pair<double, std::string>> order;
  double all = 0.0;
  for (const auto& [kind, s] : seconds) {
    order.emplace_back(s, kind);
    all += s;
  }
  std::ranges::sort(order, std::greater<>());
  std::string text = fmt::format("{:.4g} s:", all);
  for (std::size_t i = 0; i < std::min<std::size_t>(9, order.size()); ++i) {
    text += fmt::format(" {} {:.3g}", order[i].second, order[i].first);
  }
  return text;
}

void describe(const Workload& workload) {
  fmt::print("\n== {}: {} tasks\n", workload.name, workload.graph.tasks.size());
  fmt::print("work  {}\n", shares(seconds_by_kind(workload.graph)));
  fmt::print("chain {}\n", shares(longest_chain(workload.graph)));
  const Machine& m = workload.machine;
  fmt::print("every rank: scene {:.3g} s, ray caster {:.3g} s; package {:.3g} s\n", m.scene_seconds,
             m.first_task_seconds, m.assembly.at(workload.graph.package_bytes));
}

void print_rows(const std::vector<Row>& rows) {
  fmt::print("  ranks   seconds  speed-up  efficiency  coordinator  on disk  computing  read GB\n");
  for (const Row& row : rows) {
    const double rank_seconds = row.ranks * row.outcome.seconds;
    fmt::print("  {:5} {:9.1f} {:9.2f} {:11.2f} {:12.3f} {:8.3f} {:10.3f} {:8.1f}\n", row.ranks,
               row.outcome.seconds, row.speed_up, row.speed_up / row.ranks,
               row.outcome.coordinator / row.outcome.seconds, row.outcome.disk / rank_seconds,
               row.outcome.busy / rank_seconds, 1e-9 * row.outcome.read_bytes);
  }
}

class Table {
 public:
  explicit Table(const std::string& file) : out_(file) {
    if (!out_) throw std::runtime_error(file + ": cannot be written");
    out_ << "workload,ranks,tasks,seconds,speed_up,efficiency,bound,coordinator_share,disk_share,"
            "computing_share,read_bytes\n";
  }
  void add(const Workload& workload, const std::vector<Row>& rows) {
    const double chain = chain_seconds(workload.graph);
    for (const Row& row : rows) {
      const double most = workload.graph.work() / chain;  // Amdahl with the graph's own chain
      const double rank_seconds = row.ranks * row.outcome.seconds;
      out_ << fmt::format(
          "{},{},{},{:.6g},{:.6g},{:.4f},{:.6g},{:.4f},{:.4f},{:.4f},{:.4g}\n", workload.name,
          row.ranks, workload.graph.tasks.size(), row.outcome.seconds, row.speed_up,
          row.speed_up / row.ranks, std::min<double>(row.ranks, most),
          row.outcome.coordinator / row.outcome.seconds, row.outcome.disk / rank_seconds,
          row.outcome.busy / rank_seconds, row.outcome.read_bytes);
      out_.flush();
    }
  }

 private:
  std::ofstream out_;
};

/// Seconds on the first number of ranks.
double run_workload(const Workload& workload, const std::vector<int>& counts, Table& table,
                    double one = 0.0) {
  describe(workload);
  const std::vector<Row> rows = sweep(workload, counts, one);
  print_rows(rows);
  table.add(workload, rows);
  return rows.front().outcome.seconds;
}

void print_coordinator_speed() {
  fmt::print("== coordinator, 1000 workers, tasks in 10 layers\n");
  fmt::print("    tasks  inputs each  handle: tasks/s  with messages: tasks/s\n");
  for (const auto& [width, inputs] : {std::pair<std::size_t, std::size_t>{10'000, 5},
                                      {10'000, 20},
                                      {10'000, 100},
                                      {1'000, 5},
                                      {1'000, 1'000}}) {
    const CoordinatorSpeed speed = measure_coordinator(10, width, inputs, 1000);
    const auto tasks = static_cast<double>(speed.tasks);
    fmt::print("  {:7} {:12} {:16.0f} {:23.0f}\n", speed.tasks, inputs, tasks / speed.handling,
               tasks / (speed.handling + speed.messages));
  }
}

/// What single changes to the gallery's bake would bring.
void print_gallery_changes(const BakeFacts& facts, Table& table) {
  const std::map<std::string, std::size_t> split = {{"points", 8}, {"solve", 8}};
  const std::vector<Change> changes = {{.name = "gallery-even", .even_clusters = true},
                                       {.name = "gallery-split", .parts = split},
                                       {.name = "gallery-search", .search_share = 0.05},
                                       {.name = "gallery-rays-kept", .keeps_rays = true},
                                       {.name = "gallery-fast-messages", .poll_share = 0.1},
                                       {.name = "gallery-even-split-search",
                                        .parts = split,
                                        .even_clusters = true,
                                        .search_share = 0.05},
                                       {.name = "gallery-all",
                                        .parts = split,
                                        .even_clusters = true,
                                        .search_share = 0.05,
                                        .keeps_rays = true,
                                        .poll_share = 0.1}};
  for (const Change& change : changes) {
    run_workload(measured_workload(change.name, facts, change), {1, 16, 64, 256}, table);
  }
}

void print_growth(const CityFacts& facts) {
  fmt::print("\n== the plan as the scene grows: seconds of work by kind\n");
  for (const std::size_t clusters : {50, 200, 1000, 10'000}) {
    const Workload workload = city_workload(facts, plan_city(clusters, kWindow));
    fmt::print("  {} clusters, {} tasks: {}\n    longest chain {}\n", clusters,
               workload.graph.tasks.size(), shares(seconds_by_kind(workload.graph)),
               shares(longest_chain(workload.graph)));
  }
}

/// Single changes to the city's bake, and those together that belong together.
std::vector<Change> city_changes(std::size_t regions) {
  Change all{.name = "city-all",
             .parts = {{"solve", 4}, {"compare", regions / 8}},
             .scene_share = 0.1,
             .package_share = 1.0 / static_cast<double>(regions)};
  Change slow = all;
  slow.name = "city-all-slow-disk";
  slow.bandwidth_share = 0.1;
  return {all,
          {.name = "city-solve", .parts = {{"solve", 4}}},
          {.name = "city-search-whole", .search_whole = true},
          {.name = "city-scene", .scene_share = 0.1},
          {.name = "city-package",
           .parts = {{"compare", regions / 8}},
           .package_share = 1.0 / static_cast<double>(regions)},
          slow,
          {.name = "city-forgets", .forgets = true}};
}

void run_cities(const CityFacts& facts, Table& table) {
  print_growth(facts);
  const std::vector<int> counts = {1, 10, 100, 1000, 10'000};
  const CityPlan plan = plan_city(kCityClusters, kWindow);
  fmt::print("\n{} regions, their windows found in {:.3g} s\n", plan.regions.size(),
             plan.windows_seconds);
  const double one = run_workload(city_workload(facts, plan, {.name = "city"}), counts, table);
  const std::vector<int> goals = {100, 1000};
  for (const Change& change : city_changes(plan.regions.size())) {
    run_workload(city_workload(facts, plan, change), change.name == "city-all" ? counts : goals,
                 table, one);
  }
  run_workload(
      city_workload(facts, plan_city(kCityClusters, kSmallWindow), {.name = "city-small-windows"}),
      goals, table, one);
}

void replay(const std::string& folder) {
  const BakeFacts facts = read_facts(folder);
  const MeasuredBake& bake = facts.bake;
  const Workload workload = replayed_workload(facts);
  const Outcome outcome = simulate(workload.graph, workload.machine);
  fmt::print(
      "replay: the bake's {} tasks are those planned, {:.1f} s of work on {} ranks: {:.1f} s "
      "simulated, {:.1f} s taken, "
      "start-up and package included\n",
      workload.graph.tasks.size(), workload.graph.work(), bake.ranks, outcome.seconds,
      bake.wall_seconds);
}

int run(const Options& options) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // long runs are watched
  if (options.check) {
    const int wrong = check_simulation();
    fmt::print("simulate_scaling --check: {}\n", wrong == 0 ? "all holds" : "wrong");
    return wrong == 0 ? 0 : 1;
  }
  if (!options.replay.empty()) {
    replay(options.replay);
    return 0;
  }
  print_coordinator_speed();
  if (options.galleries.empty()) return 0;
  CityFacts city;
  for (const std::string& folder : options.galleries) city.bakes.push_back(read_facts(folder));
  const BakeFacts gallery = city.bakes.at(city.bakes.size() / 2);
  const BakeFacts sponza = read_facts(options.sponza);
  city.regions = read_facts(options.house);
  for (const BakeFacts& facts : city.bakes) {
    fmt::print("neighbour search of {:.0f} samples: {:.3g} s\n", facts.set_up.samples,
               facts.set_up.search_seconds);
  }
  Table table(options.csv);
  for (const auto& [name, facts] : {std::pair{"gallery", &gallery}, {"sponza", &sponza}}) {
    const Workload workload = measured_workload(name, *facts);
    run_workload(workload, rank_counts(workload.graph.tasks.size()), table);
  }
  print_gallery_changes(gallery, table);
  run_cities(city, table);
  return 0;
}

}  // namespace
}  // namespace prt::scaling

int main(int argc, char** argv) {
  prt::scaling::Options options;
  CLI::App app("Predicts how a bake scales over ranks");
  app.add_flag("--check", options.check, "check the simulation against known answers");
  CLI::Option* galleries = app.add_option(
      "--gallery", options.galleries,
      "finished bakes of one scene with ever more samples; the middle one is the paper's");
  galleries->needs(app.add_option("--sponza", options.sponza, "finished bake"));
  galleries->needs(
      app.add_option("--house", options.house, "finished bake of a scene in several regions"));
  app.add_option(
      "--replay", options.replay,
      "finished bake of several ranks, one thread each: is the simulation right about it?");
  app.add_option("--csv", options.csv, "file to write")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return prt::scaling::run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "simulate_scaling: {}\n", error.what());
    return 1;
  }
}
