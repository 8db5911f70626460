#include "player/evaluator.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "base/parallel.h"
#include "player/depth_tables.h"
#include "player/environment_light.h"
#include "player/light_samples.h"
#include "player/play_program.h"

namespace prt {
namespace {

/// Items per piece of parallel work. No sum crosses items, so threads change no result.
constexpr std::size_t kSampleGrain = 1024;
constexpr std::size_t kPointGrain = 2048;

/// What arrives at one sample from one light.
struct Arrival {
  Vec3f irradiance = Vec3f::Zero();
  float visibility = kUnlit;
};

/// What a thread works with: places on a light that shine on a sample's front, what each brings,
/// and how much of it arrives.
struct ArrivalScratch {
  std::vector<ShiningPlace> places;
  std::vector<Vec3f> irradiance;  ///< W/m², unshadowed
  std::vector<float> shares;
  DepthTables::Scratch depths;

  /// So that a light with as many points allocates nothing.
  void make_room(std::size_t points) {
    places.reserve(points);
    irradiance.reserve(points);
    shares.reserve(points);
    depths.make_room(points);
  }
};

/// False only where no point of the light is in front of the surface: then none of them needs to be
/// looked at.
bool may_shine_on(const Light& light, const Vec3f& position, const Vec3f& normal) {
  float extent = 0.0F;
  switch (light.kind) {
    case Light::Kind::kSphere:
      extent = light.radius;
      break;
    case Light::Kind::kQuad:
      extent = 0.5F * (std::abs(normal.dot(light.edge_u)) + std::abs(normal.dot(light.edge_v)));
      break;
    default:
      return true;
  }
  constexpr float kRounding = 1e-5F;
  const Vec3f offset = light.position - position;
  const float size = extent + offset.cwiseAbs().sum() + light.position.cwiseAbs().sum();
  return normal.dot(offset) + extent + kRounding * size > 0.0F;
}

}  // namespace

struct Evaluator::Tables {
  std::uint64_t number;  ///< of the evaluator; no other in this process has it
  const SampleSet& samples;
  unsigned threads;
  std::vector<std::uint32_t> cluster_of_sample;
  bool lit = false;                   ///< the program takes lights
  std::optional<DepthTables> depths;  ///< none: no shadows
  PlayProgram program;

  [[nodiscard]] Arrival arrival(std::uint32_t sample, const Light& light,
                                std::span<const Vec2f> light_points, ArrivalScratch& work) const;
  /// Adds one light's irradiance to `direct` (3 × n) and sets its visibility at the samples.
  void add_light(const Light& light, std::span<const Vec2f> light_points, MatrixF& direct,
                 std::vector<float>& visibility) const;
};

Arrival Evaluator::Tables::arrival(std::uint32_t sample, const Light& light,
                                   std::span<const Vec2f> light_points,
                                   ArrivalScratch& work) const {
  const Vec3f& position = samples.positions[sample];
  const Vec3f& normal = samples.normals[sample];
  if (!may_shine_on(light, position, normal)) return {};
  work.places.clear();
  work.irradiance.clear();
  for (const Vec2f& uv : light_points) {
    const IncidentLight incident = incident_light(light, position, uv.x(), uv.y());
    const float cosine = normal.dot(incident.to_light);
    if (!(cosine > 0.0F)) continue;
    const Vec3f irradiance = cosine * incident.irradiance;
    if (irradiance == Vec3f::Zero()) continue;  // outside a spot's cone, or behind a quad
    work.places.push_back({incident.to_light, incident.distance});
    work.irradiance.push_back(irradiance);
  }
  if (work.places.empty()) return {};
  work.shares.assign(work.places.size(), 1.0F);
  if (depths) {
    depths->visibility(sample, cluster_of_sample[sample], work.places, work.depths, work.shares);
  }
  Arrival at;
  float power = 0.0F;
  float seen = 0.0F;
  for (std::size_t k = 0; k < work.places.size(); ++k) {
    const float weight = work.irradiance[k].sum();
    at.irradiance += work.shares[k] * work.irradiance[k];
    power += weight;
    seen += work.shares[k] * weight;
  }
  if (!(power > 0.0F)) return {};
  at.irradiance /= static_cast<float>(light_points.size());
  at.visibility = seen / power;
  return at;
}

void Evaluator::Tables::add_light(const Light& light, std::span<const Vec2f> light_points,
                                  MatrixF& direct, std::vector<float>& visibility) const {
  visibility.assign(samples.size(), kUnlit);
  if (!lit) return;
  parallel_for(samples.size(), kSampleGrain, threads, [&](std::size_t begin, std::size_t end) {
    thread_local ArrivalScratch scratch;
    ArrivalScratch& work = scratch;
    work.make_room(light_points.size());
    for (std::size_t i = begin; i < end; ++i) {
      const Arrival at = arrival(static_cast<std::uint32_t>(i), light, light_points, work);
      direct.col(static_cast<Eigen::Index>(i)) += at.irradiance;
      visibility[i] = at.visibility;
    }
  });
}

Evaluator::Evaluator(const Package& package, const PlayerSettings& settings)
    : package_(package), settings_(settings), splats_(package.samples) {
  static std::atomic<std::uint64_t> evaluators = 0;
  auto tables = std::make_unique<Tables>(Tables{++evaluators,
                                                package.samples,
                                                settings.threads,
                                                package.samples.cluster_of_sample(),
                                                has_direct_light(package),
                                                {},
                                                PlayProgram(package)});
  for (const ProgramStep& step : package.program) {
    const auto* direct = std::get_if<DirectLightStep>(&step);
    if (direct != nullptr && direct->shadow == DirectLightStep::Shadow::kDepth) {
      tables->depths.emplace(*package.visibility, package.samples);
    }
  }
  tables_ = std::move(tables);
}

Evaluator::~Evaluator() = default;

SampleIrradiance Evaluator::evaluate(std::span<const Light> lights,
                                     const MatrixF& environment) const {
  SampleIrradiance result;
  evaluate(lights, environment, result);
  return result;
}

void Evaluator::evaluate(std::span<const Light> lights, const MatrixF& environment,
                         SampleIrradiance& result) const {
  check_environment(package_, environment);
  // The result's own lights may have been changed in place.
  const bool own = !lights.empty() && lights.data() == result.lights.data();
  const bool changed =
      own || result.evaluator != tables_->number || !std::ranges::equal(lights, result.lights);
  result.evaluator = tables_->number;
  if (changed) set_lights(lights, result);
  tables_->program.run(result.direct_light, environment, changed, settings_.threads, result.work,
                       result.direct, result.sky, result.indirect);
}

void Evaluator::set_lights(std::span<const Light> lights, SampleIrradiance& result) const {
  if (lights.data() != result.lights.data()) result.lights.assign(lights.begin(), lights.end());
  result.visibility.resize(lights.size());
  result.light_points.resize(lights.size());
  result.direct_light.setZero(3, static_cast<Eigen::Index>(package_.samples.size()));
  for (std::size_t l = 0; l < lights.size(); ++l) {
    light_samples(lights[l], settings_.area_samples, result.light_points[l]);
    tables_->add_light(lights[l], result.light_points[l], result.direct_light,
                       result.visibility[l]);
  }
}

MatrixF Evaluator::respond(const MatrixF& direct) const {
  SampleIrradiance result;
  tables_->program.run(direct.transpose(), {}, true, settings_.threads, result.work, result.direct,
                       result.sky, result.indirect);
  return result.indirect;
}

std::vector<float> Evaluator::visibility(const Light& light) const {
  MatrixF unused = MatrixF::Zero(3, static_cast<Eigen::Index>(package_.samples.size()));
  std::vector<Vec2f> light_points;
  light_samples(light, settings_.area_samples, light_points);
  std::vector<float> visibility;
  tables_->add_light(light, light_points, unused, visibility);
  return visibility;
}

namespace {

/// Interpolated visibility: samples that the light shines on from behind have no say.
float interpolate(std::span<const SplatWeight> weights, const std::vector<float>& visibility) {
  float sum = 0.0F;
  float total = 0.0F;
  for (const SplatWeight& w : weights) {
    if (visibility[w.sample] == kUnlit) continue;
    sum += w.weight * visibility[w.sample];
    total += w.weight;
  }
  return total > 0.0F ? sum / total : kUnlit;
}

Vec3f interpolate(std::span<const SplatWeight> weights, const MatrixF& irradiance) {
  Vec3f sum = Vec3f::Zero();
  for (const SplatWeight& w : weights)
    sum += w.weight * irradiance.block<1, 3>(w.sample, 0).transpose();
  return sum;
}

PlayedIrradiance play(const SampleIrradiance& irradiance, const PlayPoint& point,
                      std::span<const SplatWeight> weights) {
  PlayedIrradiance played;
  if (weights.empty()) return played;
  played.reached = true;
  played.indirect = interpolate(weights, irradiance.indirect);
  if (irradiance.sky.rows() > 0) played.direct = interpolate(weights, irradiance.sky);
  for (std::size_t l = 0; l < irradiance.lights.size(); ++l) {
    const float visibility = interpolate(weights, irradiance.visibility[l]);
    if (l == 0) played.visibility = visibility;
    if (!(visibility > 0.0F)) continue;
    played.direct +=
        visibility * unshadowed_irradiance(irradiance.lights[l], irradiance.light_points[l],
                                           point.position, point.shading_normal);
  }
  return played;
}

}  // namespace

std::vector<PlayedIrradiance> Evaluator::reconstruct(const SampleIrradiance& irradiance,
                                                     std::span<const PlayPoint> points) const {
  std::vector<PlayedIrradiance> played(points.size());
  parallel_for(points.size(), kPointGrain, settings_.threads,
               [&](std::size_t begin, std::size_t end) {
                 std::vector<SplatWeight> weights;
                 for (std::size_t i = begin; i < end; ++i) {
                   splats_.weights_at(points[i].position, points[i].normal, weights);
                   played[i] = play(irradiance, points[i], weights);
                 }
               });
  return played;
}

}  // namespace prt
