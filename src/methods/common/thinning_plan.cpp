#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "methods/common/inputs.h"
#include "methods/common/thinning.h"

namespace prt {

namespace {

// Around a tile everything is known so many spacings far: there, who stays depends on who is
// farther away, and after some three steps hardly ever on who is beyond.
constexpr float kHalo = 4.0F;
// Fewer are no faster than one task, what it takes to hand candidates on included.
constexpr double kFewestTiles = 3.0;

/// Plans the tasks of one scene.
class ThinningPlanner {
 public:
  ThinningPlanner(const PlanInputs& inputs, const std::vector<TaskSpec>& candidates,
                  const ThinningSize& size, const ThinningSplit& split, Plan& plan)
      : options_(inputs.options()),
        candidates_(candidates),
        split_(split),
        halo_(kHalo * size.spacing),
        tiles_(split.tiles(size.candidates)),
        per_tile_(1e-6 * size.candidates / static_cast<double>(tiles_)),
        plan_(plan) {}

  void run() {
    TaskSpec points = make("points", "points");
    points.version = 2;
    points.parameters["cluster_size"] = options_.get<std::size_t>("samples.cluster_size");
    say_how_many(points);
    if (tiles_ > 1) {
      plan_tiles();
      if (!has_spacing()) plan_spacing();
      plan_thin();
      points.inputs = spacing_input();
      for (std::size_t t = 0; t < tiles_; ++t) points.inputs.push_back(numbered("thin", t));
      points.parameters["tiles"] = tiles_;
      points.cost = 0.3 * per_tile_ * static_cast<double>(tiles_);
    }
    for (const TaskSpec& part : candidates_) points.inputs.push_back(part.id);
    plan_.tasks.push_back(points);
  }

 private:
  [[nodiscard]] TaskSpec make(const std::string& kind, const std::string& id) const {
    TaskSpec spec;
    spec.id = id;
    spec.kind = kind;
    spec.scene_parts = kGeometry;
    spec.parameters["seed"] = options_.get<std::uint64_t>("seed");
    return spec;
  }
  [[nodiscard]] bool has_spacing() const { return options_.is_set("samples.spacing"); }
  void say_how_many(TaskSpec& spec) const {
    if (has_spacing()) {
      spec.parameters["spacing"] = options_.get<double>("samples.spacing");
    } else {
      spec.parameters["count"] = options_.get<std::size_t>("samples.count");
    }
  }
  [[nodiscard]] std::vector<std::string> spacing_input() const {
    return has_spacing() ? std::vector<std::string>{} : std::vector<std::string>{"spacing"};
  }
  [[nodiscard]] std::size_t groups() const {
    return (candidates_.size() + split_.parts_per_group - 1) / split_.parts_per_group;
  }
  [[nodiscard]] static std::string tiles_id(std::size_t group, std::size_t tile_group) {
    return fmt::format("tiles/{:04}-{}", group, tile_group);
  }

  void plan_tiles() {
    for (std::size_t g = 0; g < groups(); ++g) {
      for (std::size_t first = 0; first < tiles_; first += split_.tiles_per_group) {
        TaskSpec spec = make("tiles", tiles_id(g, first / split_.tiles_per_group));
        const std::size_t begin = g * split_.parts_per_group;
        const std::size_t end = std::min(begin + split_.parts_per_group, candidates_.size());
        for (std::size_t i = begin; i < end; ++i) spec.inputs.push_back(candidates_[i].id);
        spec.parameters["tiles"] = tiles_;
        spec.parameters["first"] = first;
        spec.parameters["count"] = std::min(split_.tiles_per_group, tiles_ - first);
        spec.parameters["halo"] = halo_;
        plan_.tasks.push_back(spec);
      }
    }
  }

  /// A task that reads a tile's candidates.
  [[nodiscard]] TaskSpec of_tile(const std::string& kind, std::size_t tile) const {
    TaskSpec spec = make(kind, numbered(kind, tile));
    const std::size_t tile_group = tile / split_.tiles_per_group;
    for (std::size_t g = 0; g < groups(); ++g) spec.inputs.push_back(tiles_id(g, tile_group));
    spec.parameters["tiles"] = tiles_;
    spec.parameters["tile"] = tile;
    spec.place = numbered("tiles", tile_group);
    return spec;
  }

  void plan_spacing() {
    TaskSpec spacing = make("spacing", "spacing");
    for (std::size_t t = 0; t < tiles_; ++t) {
      TaskSpec spec = of_tile("highest", t);
      spec.cost = 0.2 * per_tile_;
      spacing.inputs.push_back(spec.id);
      plan_.tasks.push_back(spec);
    }
    say_how_many(spacing);
    spacing.cost = 0.05 * per_tile_ * static_cast<double>(tiles_);
    plan_.tasks.push_back(spacing);
  }

  void plan_thin() {
    for (std::size_t t = 0; t < tiles_; ++t) {
      TaskSpec spec = of_tile("thin", t);
      const std::vector<std::string> spacing = spacing_input();
      spec.inputs.insert(spec.inputs.begin(), spacing.begin(), spacing.end());
      spec.parameters["halo"] = halo_;
      if (has_spacing()) say_how_many(spec);
      spec.cost = 0.8 * per_tile_;
      plan_.tasks.push_back(spec);
    }
  }

  const OptionValues& options_;
  const std::vector<TaskSpec>& candidates_;
  ThinningSplit split_;
  float halo_;
  std::size_t tiles_;
  double per_tile_;  // millions of candidates: seconds, about
  Plan& plan_;
};

}  // namespace

std::size_t ThinningSplit::tiles(double candidates) const {
  const double tiles = std::ceil(candidates / candidates_per_tile);
  return tiles < kFewestTiles ? 1 : static_cast<std::size_t>(tiles);
}

void plan_points(const PlanInputs& inputs, const std::vector<TaskSpec>& candidates,
                 const ThinningSize& size, const ThinningSplit& split, Plan& plan) {
  ThinningPlanner(inputs, candidates, size, split, plan).run();
}

}  // namespace prt
