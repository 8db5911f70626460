#include "evaluate/sky_evaluation.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/random.h"
#include "evaluate/compare_sky.h"
#include "evaluate/test_points_io.h"
#include "methods/common/inputs.h"
#include "player/environment_light.h"

namespace prt {
namespace {

constexpr const char* kReference = "sky_reference";
constexpr const char* kEvaluate = "sky_evaluate";
/// Seconds per path on one core: one more shadow ray at each vertex than lights ask for.
constexpr double kSecondsPerPath = 4e-6;

constexpr int kRows = 64;
constexpr int kLobes = 3;
constexpr float kDimSky = 0.3F;  // W/(m² sr)

struct Lobe {
  Vec3f direction, colour;
  float exponent;
};

}  // namespace

Environment draw_test_environment(std::uint64_t seed, std::size_t number) {
  Random random(stream_key(seed, "test environments"), number);
  std::vector<Lobe> lobes;
  for (int k = 0; k < kLobes; ++k) {
    Lobe lobe;
    const float u = random.uniform(), v = random.uniform();
    lobe.direction = cosine_direction(Vec3f::UnitY(), u, v);
    for (int c = 0; c < 3; ++c) lobe.colour[c] = 0.2F + random.uniform();
    lobe.exponent = static_cast<float>(2 << k);
    lobes.push_back(lobe);
  }
  std::vector<Vec3f> radiance;
  const Environment grid(2 * kRows, kRows, std::vector<Vec3f>(2UL * kRows * kRows, Vec3f::Zero()));
  grid.visit(kRows, [&](const Vec3d& direction, double, const Vec3f&) {
    Vec3f sum = Vec3f::Constant(kDimSky);
    for (const Lobe& lobe : lobes) {
      const float cosine = std::max(0.0F, lobe.direction.dot(direction.cast<float>()));
      sum += std::pow(cosine, lobe.exponent) * lobe.colour;
    }
    radiance.push_back(sum);
  });
  return {2 * kRows, kRows, std::move(radiance)};
}

Plan plan_sky_evaluation(const OptionValues& options, const std::string& samples_task,
                         const std::vector<std::string>* package_results) {
  Plan plan;
  plan.complete = package_results != nullptr;
  const auto environments = options.get<std::size_t>("evaluate.environments");
  const auto points = options.get<std::size_t>("evaluate.points");
  const auto spp = options.get<int>("evaluate.spp");
  for (const std::string key : {"evaluate.environments", "evaluate.points"}) {
    if (options.get<std::size_t>(key) > 0) continue;
    plan.left_out.push_back(
        {"evaluation under environments", key + " is 0: their error is not measured"});
    return plan;
  }
  TaskSpec all;
  all.id = kEvaluate;
  all.kind = kEvaluate;
  all.parameters = {{"references", environments}, {"seed", options.get<std::uint64_t>("seed")}};
  for (std::size_t k = 0; k < environments; ++k) {
    TaskSpec spec;
    spec.id = numbered(kReference, k);
    spec.kind = kReference;
    spec.parameters = {{"environment", k},
                       {"seed", options.get<std::uint64_t>("seed")},
                       {"points", points},
                       {"spp", spp}};
    spec.inputs = {samples_task};
    spec.scene_parts = kGeometry | kMaterials;
    spec.cost = kSecondsPerPath * 2.0 * static_cast<double>(points) * spp;
    all.inputs.push_back(spec.id);
    plan.tasks.push_back(spec);
  }
  if (package_results == nullptr) return plan;
  all.inputs.insert(all.inputs.end(), package_results->begin(), package_results->end());
  plan.tasks.push_back(all);
  plan.results = {kEvaluate};
  return plan;
}

std::vector<std::string> sky_evaluation_kinds() { return {kReference, kEvaluate}; }

std::vector<StageWork> sky_evaluation_work(const BakeSize& size, const OptionValues& options) {
  if (!options.all().contains("evaluate.environments")) return {};  // no method here knows any
  const double skies = options.get<double>("evaluate.environments");
  const double points = options.get<double>("evaluate.points");
  const double paths = 2.0 * skies * points * options.get<double>("evaluate.spp");
  return {{kReference, skies, 0, paths, skies * 200.0 * points, 64.0 * size.samples},
          {kEvaluate, 1, 0, skies * size.samples, 5000, 400.0 * size.samples}};
}

Artifact run_sky_reference(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto search = shared_search(reader, 0);
  const auto& p = task.parameters;
  ReferenceSettings settings;
  settings.seed = p["seed"].get<std::uint64_t>();
  settings.points = p["points"].get<std::size_t>();
  settings.paths = p["spp"].get<int>();
  const auto number = p["environment"].get<std::size_t>();
  const ReferenceInputs inputs{reader.scene(), reader.ray_caster(), shared->samples, *search};
  Artifact out;
  put_test_points(out, trace_sky_reference(inputs, settings, number,
                                           draw_test_environment(settings.seed, number), 1,
                                           [&] { check_stop(reader); }));
  return out;
}

Artifact run_sky_evaluate(const TaskSpec& task, const TaskReader& reader, const Evaluator& player) {
  const int order = environment_order(player.package());
  const auto seed = task.parameters["seed"].get<std::uint64_t>();
  std::vector<SkyErrors> skies;
  for (std::size_t k = 0; k < task.parameters["references"].get<std::size_t>(); ++k) {
    check_stop(reader);
    const TestPoints reference = get_test_points(*reader.input(k));
    for (const std::uint32_t s : reference.sample_index) {
      if (s >= player.package().samples.size()) {
        throw UnsoundData("a reference names a sample that is not there");
      }
    }
    const EnvironmentLight light(draw_test_environment(seed, k), order);
    skies.push_back(compare_sky(player, light.coefficients(), reference));
    if (skies.back().not_finite() > 0) {
      throw UnsoundData(
          fmt::format("{} values of {} are not finite", skies.back().not_finite(), task.inputs[k]));
    }
  }
  Artifact out;
  out.attributes["error"] = {{"environment", sky_error_report(skies)}};
  return out;
}

}  // namespace prt
