#include "methods/common/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "base/random.h"
#include "methods/common/inputs.h"
#include "store/samples_io.h"
#include "transport/area_points.h"
#include "transport/cells.h"
#include "transport/particles.h"

namespace prt {

namespace {

// Candidates per wanted sample: more closes the gaps of the Poisson-disk set, fewer saves rays.
constexpr double kCandidatesPerSample = 24.0;
// Points uniform in area per wanted sample, for ground that particles seldom meet: less than one
// disk in a hundred stays empty where they alone cover the surface, and half of it is out of reach.
constexpr double kAreaPointsPerSample = 4.0;
constexpr std::size_t kCandidatesPerTask = 100000;
constexpr std::size_t kRaysPerCandidate = 40;  // budget where most particles escape
constexpr std::uint64_t kParticlesPerTask = std::uint64_t{1} << 40;
// Points per sample cell: on the gallery cell areas come out to about 18 %, cluster areas to 0.6 %.
constexpr double kPointsPerCell = 32.0;
constexpr std::uint64_t kPointsPerTask = 100000;
constexpr std::uint64_t kMostPoints = 60'000'000;
// Colours closer than this are grey.
constexpr double kGreySpread = 1e-6;
// A maximal Poisson-disk set of radius r has about this many samples per r².
constexpr double kSamplesPerSquareRadius = 0.8;

TaskSpec task(const std::string& id, const std::string& kind, int version) {
  TaskSpec spec;
  spec.id = id;
  spec.kind = kind;
  spec.version = version;
  return spec;
}

/// Samples wanted; with a spacing, as many as the whole surface (both sides) could hold at most.
std::size_t wanted_samples(const PlanInputs& inputs) {
  if (!inputs.options().is_set("samples.spacing")) {
    return inputs.options().get<std::size_t>("samples.count");
  }
  const double spacing = inputs.options().get<double>("samples.spacing");
  double area = 0.0;
  for (std::uint32_t t = 0; t < inputs.scene().triangles.size(); ++t) {
    area += triangle_area(inputs.scene(), t);
  }
  return static_cast<std::size_t>(
      std::clamp(kSamplesPerSquareRadius * 2.0 * area / (spacing * spacing), 1.0, 2e7));
}

double expected_candidates(double samples) {
  return (kCandidatesPerSample + kAreaPointsPerSample / 2.0) * samples;
}

ThinningSize thinning_size(const PlanInputs& inputs) {
  ThinningSize size;
  const auto samples = static_cast<double>(wanted_samples(inputs));
  size.candidates = expected_candidates(samples);
  if (inputs.options().is_set("samples.spacing")) {
    size.spacing = inputs.options().get<float>("samples.spacing");
  } else {
    // Were both sides of all surfaces within reach.
    const double area = 2.0 * cumulative_areas(inputs.scene()).back();
    size.spacing = static_cast<float>(std::sqrt(kSamplesPerSquareRadius * area / samples));
  }
  return size;
}

/// samples.start is a place in the world, or several.
nlohmann::json start_in_scene(const nlohmann::json& start, const Scene& scene) {
  if (!scene.recentred()) return start;
  if (start[0].is_array()) {
    nlohmann::json all = nlohmann::json::array();
    for (const auto& one : start) all.push_back(start_in_scene(one, scene));
    return all;
  }
  const auto world = start.get<std::array<double, 3>>();
  const Vec3d place = Vec3d(world[0], world[1], world[2]) - scene.origin;
  return {place.x(), place.y(), place.z()};
}

TaskSpec start_task(const PlanInputs& inputs) {
  TaskSpec spec = task("start", "start", 4);
  spec.scene_parts = kGeometry;
  spec.cost = 0.2;
  const auto& options = inputs.options();
  spec.parameters["seed"] = options.get<std::uint64_t>("seed");
  if (!options.is_auto("samples.start")) {
    spec.parameters["start"] = start_in_scene(options.at("samples.start"), inputs.scene());
  } else if (inputs.scene().camera) {
    const Vec3f& eye = inputs.scene().camera->eye;
    spec.parameters["start"] = {eye.x(), eye.y(), eye.z()};
  }
  return spec;
}

std::vector<TaskSpec> candidate_tasks(const PlanInputs& inputs) {
  const auto samples = static_cast<double>(std::max<std::size_t>(100, wanted_samples(inputs)));
  const auto wanted = static_cast<std::size_t>(kCandidatesPerSample * samples);
  const std::size_t tasks = (wanted + kCandidatesPerTask - 1) / kCandidatesPerTask;
  std::vector<TaskSpec> result;
  for (std::size_t i = 0; i < tasks; ++i) {
    TaskSpec spec = task(numbered("candidates", i), "candidates", 4);
    spec.inputs = {"start"};
    spec.scene_parts = kGeometry;
    spec.parameters = {{"seed", inputs.options().get<std::uint64_t>("seed")},
                       {"wanted", (wanted + tasks - 1) / tasks},
                       {"area_points", static_cast<std::uint64_t>(kAreaPointsPerSample * samples)},
                       {"part", i},
                       {"parts", tasks}};
    spec.cost = 0.4;
    result.push_back(spec);
  }
  return result;
}

std::vector<TaskSpec> cell_tasks(const PlanInputs& inputs, double spacing) {
  const double area = cumulative_areas(inputs.scene()).back();
  const double per_point = spacing * spacing / kSamplesPerSquareRadius / kPointsPerCell;
  const auto total = static_cast<std::uint64_t>(
      std::clamp(area / per_point, 1000.0, static_cast<double>(kMostPoints)));
  std::vector<TaskSpec> result;
  for (std::uint64_t first = 0; first < total; first += kPointsPerTask) {
    TaskSpec spec = task(numbered("cells", result.size()), "cells", 5);
    spec.inputs = {"points"};
    spec.scene_parts = kGeometry;
    spec.parameters = {{"seed", inputs.options().get<std::uint64_t>("seed")},
                       {"total", total},
                       {"first", first},
                       {"count", std::min(kPointsPerTask, total - first)}};
    spec.cost = 0.2;
    result.push_back(spec);
  }
  return result;
}

Vec3f point_of(const nlohmann::json& xyz) {
  return {xyz[0].get<float>(), xyz[1].get<float>(), xyz[2].get<float>()};
}

Artifact run_start(const TaskSpec& task, const TaskReader& reader) {
  std::vector<Vec3f> starts;
  const auto& p = task.parameters;
  if (!p.contains("start")) {
    starts.push_back(find_start(reader.scene(), reader.ray_caster(),
                                stream_key(p["seed"].get<std::uint64_t>(), "start")));
  } else if (p["start"][0].is_array()) {
    for (const auto& start : p["start"]) starts.push_back(point_of(start));
  } else {
    starts.push_back(point_of(p["start"]));
  }
  Artifact out;
  out.put("start", starts, "m", "where sampling particles start");
  return out;
}

/// As many particles from each start, and points that light from any of them can reach.
Artifact run_candidates(const TaskSpec& task, const TaskReader& reader) {
  const std::vector<Vec3f> starts = reader.input(0)->points("start");
  const auto seed = task.parameters["seed"].get<std::uint64_t>();
  ParticleSettings settings;
  settings.wanted = task.parameters["wanted"].get<std::size_t>() / starts.size();
  settings.ray_budget = kRaysPerCandidate * settings.wanted;
  settings.first_particle = task.parameters["part"].get<std::uint64_t>() * kParticlesPerTask;
  SurfacePoints points;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    settings.start = starts[i];
    settings.stream = stream_key(seed, i == 0 ? "candidates" : fmt::format("candidates {}", i));
    points.append(trace_particles(reader.scene(), reader.ray_caster(), settings));
  }
  AreaPointSettings area;
  area.starts = starts;
  area.total = task.parameters["area_points"].get<std::uint64_t>();
  area.first = task.parameters["part"].get<std::uint64_t>();
  area.step = task.parameters["parts"].get<std::uint64_t>();
  area.stream = stream_key(seed, "area points");
  points.append(draw_area_points(reader.scene(), reader.ray_caster(), points, area));
  Artifact out;
  out.put("position", points.positions, "m", "candidate positions");
  out.put("normal", points.normals, "1", "unit geometric normals on the side hit");
  out.put<std::uint32_t>("triangle", points.triangles, {points.size()}, "1", "triangle hit");
  return out;
}

Artifact run_cells(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto search = shared_search(reader, 0);
  const auto& p = task.parameters;
  const CellPoints points =
      draw_cell_points(reader.scene(), reader.ray_caster(), shared->samples, *search,
                       cumulative_areas(reader.scene()), p["total"].get<std::uint64_t>(),
                       p["first"].get<std::uint64_t>(), p["count"].get<std::uint64_t>(),
                       stream_key(p["seed"].get<std::uint64_t>(), "cells"));
  Artifact out;
  const std::uint64_t n = points.samples.size();
  out.put<std::uint32_t>("sample", points.samples, {n}, "1", "sample whose cell the point lies in");
  out.put<std::uint32_t>("triangle", points.triangles, {n}, "1", "triangle of the point");
  out.put<float>("barycentric", points.barycentric, {n, 2}, "1", "weights of vertices 1 and 2");
  out.attributes["area_per_point"] =
      cumulative_areas(reader.scene()).back() / p["total"].get<double>();
  return out;
}

Artifact run_samples(const TaskSpec& task, const TaskReader& reader) {
  const auto points = reader.input(0);
  SampleSet samples = get_samples(*points);
  std::vector<std::uint32_t> counts(samples.size(), 0);
  double per_point = 0.0;
  for (std::size_t i = 1; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i);
    per_point = part->attribute<double>("area_per_point");
    for (const auto s : part->values<std::uint32_t>("sample")) ++counts[s];
  }
  // A cell that no point fell into is smaller than the points can tell; it keeps half a point's
  // area.
  std::uint64_t empty = 0;
  for (const auto count : counts) {
    empty += count == 0 ? 1 : 0;
    samples.areas.push_back(
        static_cast<float>(std::max(0.5, static_cast<double>(count)) * per_point));
  }
  Artifact out;
  put_samples(out, samples);
  out.datasets["root"] = points->at("root");
  out.attributes = points->attributes;
  out.attributes["empty_cells"] = empty;
  double area = 0.0;
  for (const float a : samples.areas) area += a;
  out.attributes["area"] = area;
  return out;
}

Artifact run_albedo(const TaskSpec& task, const TaskReader& reader) {
  const Scene& scene = reader.scene();
  const SampleSet& samples = shared_samples(reader, 0)->samples;
  MatrixD sums = MatrixD::Zero(static_cast<Eigen::Index>(samples.size()), 4);
  for (std::size_t i = 1; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i);
    const auto cell = part->values<std::uint32_t>("sample");
    const auto triangle = part->values<std::uint32_t>("triangle");
    const auto barycentric = part->values<float>("barycentric");
    for (std::size_t k = 0; k < cell.size(); ++k) {
      const Vec3f a = albedo_at(scene, triangle[k], barycentric[2 * k], barycentric[2 * k + 1]);
      sums.row(cell[k]) += Eigen::RowVector4d(a.x(), a.y(), a.z(), 1.0);
    }
  }
  MatrixF albedo(sums.rows(), 3);
  double largest = 0.0;
  double colour = 0.0;
  for (Eigen::Index s = 0; s < sums.rows(); ++s) {
    if (sums(s, 3) > 0.0) {
      albedo.row(s) = (sums.row(s).head(3) / sums(s, 3)).cast<float>();
    } else {
      const Vec3f a = albedo_at(scene, samples.triangles[s], 1.0F / 3, 1.0F / 3);
      for (int c = 0; c < 3; ++c) albedo(s, c) = a[c];
    }
    largest = std::max<double>(largest, albedo.row(s).maxCoeff());
    colour = std::max<double>(colour, albedo.row(s).maxCoeff() - albedo.row(s).minCoeff());
  }
  Artifact out;
  out.put("albedo", albedo, "1", "mean albedo of the sample's cell, linear RGB");
  out.attributes["largest"] = largest;
  out.attributes["colour_spread"] = colour;
  return out;
}

}  // namespace

bool plan_sampling(const PlanInputs& inputs, Plan& plan, const ThinningSplit& split) {
  plan.tasks.push_back(start_task(inputs));
  const auto candidates = candidate_tasks(inputs);
  plan.tasks.insert(plan.tasks.end(), candidates.begin(), candidates.end());
  plan_points(inputs, candidates, thinning_size(inputs), split, plan);
  const auto points = inputs.result("points");
  if (!points) return false;
  const auto cells = cell_tasks(inputs, points->attribute<double>("spacing"));
  plan.tasks.insert(plan.tasks.end(), cells.begin(), cells.end());
  TaskSpec samples = task(kSamplesTask, "samples", 1);
  TaskSpec albedo = task(kAlbedoTask, "albedo", 1);
  samples.inputs = albedo.inputs = {"points"};
  for (const auto& c : cells) {
    samples.inputs.push_back(c.id);
    albedo.inputs.push_back(c.id);
  }
  albedo.scene_parts = kGeometry | kMaterials;
  plan.tasks.push_back(samples);
  plan.tasks.push_back(albedo);
  return inputs.result(kSamplesTask) != nullptr;
}

SamplingTasks sampling_tasks(double samples) {
  SamplingTasks tasks;
  tasks.candidates = expected_candidates(samples);
  tasks.candidate_tasks =
      std::ceil(kCandidatesPerSample * std::max(100.0, samples) / kCandidatesPerTask);
  const ThinningSplit split;
  tasks.tiles = static_cast<double>(split.tiles(tasks.candidates));
  if (tasks.tiles > 1.0) {
    tasks.sorting_tasks =
        std::ceil(tasks.candidate_tasks / static_cast<double>(split.parts_per_group)) *
        std::ceil(tasks.tiles / static_cast<double>(split.tiles_per_group));
  }
  tasks.cell_points = std::min(kPointsPerCell * samples, static_cast<double>(kMostPoints));
  tasks.cell_tasks = std::ceil(tasks.cell_points / kPointsPerTask);
  return tasks;
}

double expected_samples(const OptionValues& options, double area) {
  if (!options.is_set("samples.spacing")) return options.get<double>("samples.count");
  const double spacing = options.get<double>("samples.spacing");
  return std::max(1.0, kSamplesPerSquareRadius * area / (spacing * spacing));
}

int colour_channels(const Artifact& albedo) {
  return albedo.attribute<double>("colour_spread") <= kGreySpread ? 1 : 3;
}

std::vector<std::string> sampling_kinds() {
  std::vector<std::string> kinds = {"start", "candidates"};
  for (const std::string& kind : thinning_kinds()) kinds.push_back(kind);
  for (const char* kind : {"cells", "samples", "albedo"}) kinds.emplace_back(kind);
  return kinds;
}

Artifact run_sampling(const TaskSpec& task, const TaskReader& reader) {
  if (task.kind == "start") return run_start(task, reader);
  if (task.kind == "candidates") return run_candidates(task, reader);
  if (task.kind == "cells") return run_cells(task, reader);
  if (task.kind == "samples") return run_samples(task, reader);
  if (task.kind == "albedo") return run_albedo(task, reader);
  return run_thinning(task, reader);
}

}  // namespace prt
