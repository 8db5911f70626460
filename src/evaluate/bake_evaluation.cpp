#include "evaluate/bake_evaluation.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "evaluate/light_errors_io.h"
#include "evaluate/reference.h"
#include "evaluate/test_points_io.h"
#include "methods/common/inputs.h"
#include "transport/free_space.h"

namespace prt {
namespace {

constexpr const char* kReference = "reference";
constexpr const char* kCompare = "compare";
constexpr const char* kEvaluate = "evaluate";
/// Each task reads the whole package, so more tasks than this would mostly read.
constexpr std::size_t kMostComparisons = 8;
/// Seconds per path on one core, measured on the gallery; only orders the tasks.
constexpr double kSecondsPerPath = 3e-6;

Artifact to_artifact(const LightReference& reference) {
  Artifact out;
  out.put("light_position", std::vector<Vec3f>{reference.light.position}, "m",
          "white point light of 1 W/sr");
  out.put<float>("direct", reference.direct, {reference.direct.size()}, "W/m^2",
                 "direct irradiance at every sample, exact");
  put_test_points(out, reference);
  return out;
}

LightReference from_artifact(const Artifact& in) {
  LightReference reference;
  const auto position = in.points("light_position");
  if (position.size() != 1) throw UnsoundData("a reference has not exactly one light");
  reference.light.position = position[0];
  static_cast<TestPoints&>(reference) = get_test_points(in);
  reference.direct = in.vector<float>("direct");
  return reference;
}

TaskSpec reference_task(const OptionValues& options, const std::string& samples_task,
                        std::size_t number) {
  TaskSpec spec;
  spec.id = numbered(kReference, number);
  spec.kind = kReference;
  spec.version = 2;
  const auto points = options.get<std::size_t>("evaluate.points");
  const auto spp = options.get<int>("evaluate.spp");
  spec.parameters = {{"light", number},
                     {"seed", options.get<std::uint64_t>("seed")},
                     {"points", points},
                     {"spp", spp}};
  spec.inputs = {samples_task};
  spec.scene_parts = kGeometry | kMaterials;
  spec.cost = kSecondsPerPath * 2.0 * static_cast<double>(points) * spp;
  return spec;
}

/// Compares what the package plays under the test lights [first, end).
TaskSpec compare_task(std::size_t number, std::size_t first, std::size_t end,
                      const std::vector<std::string>& package_results) {
  TaskSpec spec;
  spec.id = numbered(kCompare, number);
  spec.kind = kCompare;
  spec.version = 4;
  spec.parameters = {{"references", end - first}};
  for (std::size_t k = first; k < end; ++k) spec.inputs.push_back(numbered(kReference, k));
  spec.inputs.insert(spec.inputs.end(), package_results.begin(), package_results.end());
  spec.cost = 0.3 + 0.03 * static_cast<double>(end - first);
  spec.place = kCompare;  // a rank makes the package once
  return spec;
}

/// The comparisons and the task that pools them.
void add_comparisons(std::size_t lights, const std::vector<std::string>& package_results,
                     Plan& plan) {
  TaskSpec all;
  all.id = kEvaluate;
  all.kind = kEvaluate;
  all.version = 5;
  const std::size_t tasks = std::min(lights, kMostComparisons);
  for (std::size_t k = 0; k < tasks; ++k) {
    plan.tasks.push_back(
        compare_task(k, k * lights / tasks, (k + 1) * lights / tasks, package_results));
    all.inputs.push_back(plan.tasks.back().id);
  }
  plan.tasks.push_back(all);
}

}  // namespace

Plan plan_evaluation(const OptionValues& options, const std::string& samples_task,
                     const std::vector<std::string>* package_results) {
  Plan plan;
  plan.complete = package_results != nullptr;
  const auto lights = options.get<std::size_t>("evaluate.lights");
  for (const std::string key : {"evaluate.lights", "evaluate.points"}) {
    if (options.get<std::size_t>(key) > 0) continue;
    plan.left_out.push_back({"evaluation", key + " is 0: the error is not measured"});
    return plan;
  }
  for (std::size_t k = 0; k < lights; ++k) {
    plan.tasks.push_back(reference_task(options, samples_task, k));
  }
  if (package_results == nullptr) return plan;
  add_comparisons(lights, *package_results, plan);
  plan.results = {kEvaluate};
  return plan;
}

std::vector<StageWork> evaluation_work(const BakeSize& size, const OptionValues& options) {
  const double lights = options.get<double>("evaluate.lights");
  const double points = options.get<double>("evaluate.points");
  const double paths = 2.0 * lights * points * options.get<double>("evaluate.spp");
  // Two sets of points with 25 floats each; direct light at every sample.
  const double bytes = lights * (2.0 * 4.0 * 25.0 * points + 4.0 * size.samples);
  return {{kReference, lights, 0, paths, bytes, 64.0 * size.samples},
          {kCompare, std::min<double>(lights, kMostComparisons), 0, lights * size.samples,
           200.0 * lights * (1.0 + size.clusters), 400.0 * size.samples},
          {kEvaluate, 1, 0, lights, 5000, 400.0 * lights * size.clusters}};
}

std::vector<std::string> evaluation_kinds() { return {kReference, kCompare, kEvaluate}; }

Artifact run_reference(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto search = shared_search(reader, 0);
  const auto& p = task.parameters;
  ReferenceSettings settings;
  settings.seed = p["seed"].get<std::uint64_t>();
  settings.points = p["points"].get<std::size_t>();
  settings.paths = p["spp"].get<int>();
  settings.clearance = light_clearance(shared->samples, kTestClearance);
  const ReferenceInputs inputs{reader.scene(), reader.ray_caster(), shared->samples, *search};
  return to_artifact(trace_reference(inputs, settings, p["light"].get<std::size_t>(), 1,
                                     [&] { check_stop(reader); }));
}

Artifact run_compare(const TaskSpec& task, const TaskReader& reader, const Evaluator& player) {
  const std::size_t samples = player.package().samples.size();
  std::vector<LightErrors> lights;
  for (std::size_t k = 0; k < task.parameters["references"].get<std::size_t>(); ++k) {
    check_stop(reader);
    const LightReference reference = from_artifact(*reader.input(k));
    if (reference.direct.size() != samples) {
      throw UnsoundData("a reference has another number of samples");
    }
    for (const std::uint32_t s : reference.sample_index) {
      if (s >= samples) throw UnsoundData("a reference names a sample that is not there");
    }
    lights.push_back(compare(player, reference));
    if (lights.back().not_finite() > 0) {
      throw UnsoundData(fmt::format("{} values of {} are not finite", lights.back().not_finite(),
                                    task.inputs[k]));
    }
  }
  Artifact out;
  put_light_errors(out, lights);
  return out;
}

Artifact run_evaluate(const TaskSpec& task, const TaskReader& reader) {
  std::vector<LightErrors> lights;
  for (std::size_t k = 0; k < task.inputs.size(); ++k) {
    const auto part = get_light_errors(*reader.input(k));
    const auto clusters = [](const LightErrors& light) { return light.direct_by_cluster.size(); };
    if (part.empty() || (!lights.empty() && clusters(part[0]) != clusters(lights[0]))) {
      throw UnsoundData("comparisons of test lights do not fit together");
    }
    lights.insert(lights.end(), part.begin(), part.end());
  }
  Artifact out;
  std::vector<float> single;
  for (const LightErrors& light : lights) {
    for (const IrradianceSums& sums : {light.direct, light.indirect}) {
      single.push_back(static_cast<float>(irradiance_error({&sums, 1}).rel_rmse));
    }
  }
  out.put<float>("rel_rmse_of_light", single, {lights.size(), 2}, "1",
                 "relative error of direct and indirect irradiance at samples, by test light");
  out.attributes["error"] = error_report(lights);
  return out;
}

nlohmann::json summarise(const Artifact& evaluate, const Vec3d& origin) {
  auto error = evaluate.attribute<nlohmann::json>("error");
  place_in_world(error, origin);
  return error;
}

}  // namespace prt
