#include "scaling/bake_graph.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>

#include "evaluate/bake_evaluation.h"
#include "methods/common/sampling.h"
#include "methods/lb/lb.h"
#include "methods/lb/scene_part.h"

namespace prt::scaling {

namespace {

/// One triangle of that area: planning asks a scene for no more.
Scene scene_of(double area) {
  Scene scene;
  scene.positions = {Vec3f(0, 0, 0), Vec3f(static_cast<float>(2.0 * area), 0, 0), Vec3f(0, 1, 0)};
  scene.triangles = {{{0, 1, 2}, 0, 0}};
  return scene;
}

/// Answers the planner as if all that it has planned were done.
class PretendedBake : public PlanInputs {
 public:
  explicit PretendedBake(const GraphSettings& settings)
      : s_(settings), scene_(scene_of(settings.area)), samples_(samples()) {}

  [[nodiscard]] const Scene& scene() const override { return scene_; }
  [[nodiscard]] const OptionValues& options() const override { return s_.options; }
  [[nodiscard]] std::shared_ptr<const Artifact> result(const std::string& id) const override {
    if (!done_.contains(id)) return nullptr;
    if (id == kSamplesTask) return samples_;
    auto artifact = std::make_shared<Artifact>();
    if (id == "points") {
      artifact->attributes = {{"spacing", s_.spacing}};
    } else if (id == kAlbedoTask) {
      artifact->attributes = {{"largest", 0.5}, {"colour_spread", s_.grey ? 0.0 : 0.5}};
    } else if (id == lb::kWindowsTask) {
      if (s_.regions.empty()) throw std::logic_error("no regions are known of this bake");
      *artifact = lb::put_regions(s_.regions, 2.0);
    } else if (id.starts_with("residual/")) {
      artifact->attributes = {{"squared_residual", 0.0}, {"squared_source", 1.0}};
    } else if (id.starts_with("visibility/")) {  // what follows tells what was left out: nothing
      artifact->attributes = {{"escaped_share", 0.0},
                              {"unoccluded", 0},
                              {"samples", 0},
                              {"rank", s_.options.get<int>("lb.visibility_rank")}};
    } else if (id == "light_functions") {
      artifact->attributes = {{"needless", 0}, {"needless_effect", 0.0}};
    } else if (id.starts_with("transfer/")) {
      artifact->put<std::uint32_t>("senders", {}, {0}, "1", "clusters that send");
      artifact->attributes = {{"error_dropped", 0.0}};
    } else {
      throw std::logic_error(id + ": planning has not looked at it so far");
    }
    return artifact;
  }

  [[nodiscard]] bool is_done(const std::string& id) const { return done_.contains(id); }
  void finish(const std::vector<TaskSpec>& tasks) {
    for (const TaskSpec& task : tasks) done_.insert(task.id);
  }

 private:
  /// All samples of a cluster at its centre.
  [[nodiscard]] std::shared_ptr<const Artifact> samples() const {
    auto artifact = std::make_shared<Artifact>();
    std::vector<std::uint32_t> begin = {0};
    for (const double size : s_.sizes) {
      begin.push_back(begin.back() + static_cast<std::uint32_t>(std::lround(size)));
    }
    artifact->put<std::uint32_t>("cluster_begin", begin, {begin.size()}, "1", "first samples");
    if (s_.regions.empty()) return artifact;
    std::vector<Vec3f> positions;
    positions.reserve(begin.back());
    for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
      positions.insert(positions.end(), begin[c + 1] - begin[c], s_.centres.at(c));
    }
    artifact->put("position", positions, "m", "sample positions");
    return artifact;
  }

  const GraphSettings& s_;
  Scene scene_;
  std::shared_ptr<const Artifact> samples_;
  std::set<std::string> done_;
};

class Builder {
 public:
  Builder(const GraphSettings& settings, const Cost& cost)
      : s_(settings), cost_(cost), clusters_(settings.sizes.size()) {
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) clusters_[c] = c;
  }

  /// As apps/bake/planner.h plans, call by call.
  BakeGraph build() {
    PretendedBake bake(s_);
    for (bool complete = false; !complete;) {
      Plan plan = lb_method().plan(bake);
      complete = plan.complete;
      if (bake.is_done("points")) {
        Plan extra = plan_evaluation(s_.options, kSamplesTask, complete ? &plan.results : nullptr);
        std::ranges::move(extra.tasks, std::back_inserter(plan.tasks));
      }
      for (const TaskSpec& task : plan.tasks) {
        if (!bake.is_done(task.id)) add(task);
      }
      if (!graph_.plans.empty() && graph_.plans.back() == graph_.tasks.size() && !complete) {
        throw std::logic_error("the planner waits for nothing");
      }
      graph_.end_plan();
      bake.finish(plan.tasks);
    }
    return std::move(graph_);
  }

 private:
  [[nodiscard]] double samples_of(const std::vector<std::uint32_t>& clusters) const {
    return std::accumulate(clusters.begin(), clusters.end(), 0.0,
                           [&](double sum, std::uint32_t c) { return sum + s_.sizes[c]; });
  }
  [[nodiscard]] TaskSize size_of(const TaskSpec& task) const {
    const auto& p = task.parameters;
    const Region* region =
        p.contains("region") ? &s_.regions.at(p["region"].get<std::size_t>()) : nullptr;
    const auto& window = region != nullptr ? region->window : clusters_;
    const auto reach = static_cast<double>(window.size());
    if (const auto cluster = cluster_of(task)) return {s_.sizes.at(*cluster), reach};
    const bool is_of_region = task.kind == "light_functions" || task.kind == "lights";
    return {samples_of(region != nullptr && is_of_region ? region->clusters : window), reach};
  }

  void add(const TaskSpec& task) {
    Load load = cost_(task, size_of(task));
    TaskSpec spec = task;
    spec.inputs.clear();
    // Candidates are read only where thinning in tiles does not do.
    const bool has_tiles = task.kind == "points" && task.parameters.contains("tiles");
    for (const std::string& id : task.inputs) {
      if (has_tiles && id.starts_with("candidates/")) continue;
      const auto several = in_parts_.find(id);
      if (several == in_parts_.end()) {
        spec.inputs.push_back(id);
      } else {
        spec.inputs.insert(spec.inputs.end(), several->second.begin(), several->second.end());
      }
    }
    const auto wanted = s_.parts.find(task.kind);
    if (wanted == s_.parts.end()) return graph_.add(std::move(spec), load);
    const std::size_t parts = wanted->second;
    for (double* share : {&load.seconds, &load.bytes, &load.use_seconds, &spec.cost}) {
      *share /= static_cast<double>(parts);
    }
    const std::vector<std::string> inputs = std::move(spec.inputs);
    for (std::size_t i = 0; i < parts; ++i) {
      spec.id = fmt::format("{}#{}", task.id, i);
      spec.parameters["part"] = i;
      const auto at = [&](std::size_t k) {
        return inputs.begin() + static_cast<std::ptrdiff_t>(k * inputs.size() / parts);
      };
      spec.inputs.assign(at(i), at(i + 1));
      in_parts_[task.id].push_back(spec.id);
      graph_.add(spec, load);
    }
  }

  const GraphSettings& s_;
  const Cost& cost_;
  std::vector<std::uint32_t> clusters_;
  std::map<std::string, std::vector<std::string>> in_parts_;
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

std::optional<std::size_t> cluster_of(const TaskSpec& task) {
  if (task.parameters.contains("cluster")) return task.parameters["cluster"].get<std::size_t>();
  // What reads nothing but a cluster's rays need not know its number.
  const std::string rays = "rays/";
  if (task.inputs.empty() || !task.inputs.front().starts_with(rays)) return std::nullopt;
  return std::stoul(task.inputs.front().substr(rays.size()));
}

BakeGraph make_lb_graph(const GraphSettings& settings, const Cost& cost) {
  return Builder(settings, cost).build();
}

std::vector<std::size_t> regions_of_clusters(const std::vector<Region>& regions,
                                             std::size_t clusters) {
  std::vector<std::size_t> region_of(clusters, 0);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    for (const std::uint32_t c : regions[r].clusters) region_of[c] = r;
  }
  return region_of;
}

}  // namespace prt::scaling
