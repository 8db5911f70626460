#include "player/evaluator.h"

#include <map>
#include <optional>

#include "base/parallel.h"
#include "player/decoded_operators.h"
#include "player/depth_tables.h"
#include "player/light_samples.h"

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

/// A value of the program. Irradiance at samples (n × 3) has two parts; coefficients (K × 3) stand
/// in `indirect` and have a layout. A part without entries is zero.
struct Value {
  MatrixF direct;
  MatrixF indirect;
  std::vector<std::uint32_t> layout;
};

MatrixF sum(const MatrixF& a, const MatrixF& b) {
  if (a.size() == 0) return b;
  if (b.size() == 0) return a;
  return a + b;
}

}  // namespace

struct Evaluator::Tables {
  const SampleSet& samples;
  unsigned threads;
  std::vector<std::uint32_t> cluster_of_sample;
  std::optional<DepthTables> depths;  ///< none: no shadows
  std::map<std::string, DecodedOperator> operators;

  [[nodiscard]] Arrival arrival(std::uint32_t sample, const Light& light,
                                std::span<const Vec2f> light_points) const;
  /// Adds one light's irradiance to `direct` (n × 3) and returns its visibility at the samples.
  std::vector<float> add_light(const Light& light, int area_samples, MatrixF& direct) const;
  [[nodiscard]] Value apply(const DecodedOperator& op, const Value& input) const;
};

Arrival Evaluator::Tables::arrival(std::uint32_t sample, const Light& light,
                                   std::span<const Vec2f> light_points) const {
  Arrival at;
  float power = 0.0F;
  float seen = 0.0F;
  for (const Vec2f& uv : light_points) {
    const IncidentLight incident = incident_light(light, samples.positions[sample], uv.x(), uv.y());
    const float cosine = samples.normals[sample].dot(incident.to_light);
    if (!(cosine > 0.0F)) continue;
    const Vec3f irradiance = cosine * incident.irradiance;
    const float share = depths ? depths->visibility(sample, cluster_of_sample[sample],
                                                    incident.to_light, incident.distance)
                               : 1.0F;
    at.irradiance += share * irradiance;
    const float weight = irradiance.sum();
    power += weight;
    seen += share * weight;
  }
  if (!(power > 0.0F)) return {};
  at.irradiance /= static_cast<float>(light_points.size());
  at.visibility = seen / power;
  return at;
}

std::vector<float> Evaluator::Tables::add_light(const Light& light, int area_samples,
                                                MatrixF& direct) const {
  std::vector<float> visibility(samples.size());
  const std::vector<Vec2f> light_points = light_samples(light, area_samples);
  parallel_for(samples.size(), kSampleGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Arrival at = arrival(static_cast<std::uint32_t>(i), light, light_points);
      direct.block<1, 3>(static_cast<Eigen::Index>(i), 0) += at.irradiance.transpose();
      visibility[i] = at.visibility;
    }
  });
  return visibility;
}

Value Evaluator::Tables::apply(const DecodedOperator& op, const Value& input) const {
  const MatrixF in = sum(input.direct, input.indirect);
  if (const auto* projection = std::get_if<DecodedProjection>(&op)) {
    return {{}, projection->apply(in, samples, threads), projection->layout()};
  }
  if (const auto* near = std::get_if<DecodedNear>(&op)) return {{}, near->apply(in, threads), {}};
  return {{}, std::get<DecodedTransfer>(op).apply(in, input.layout, samples, threads), {}};
}

Evaluator::Evaluator(const Package& package, const PlayerSettings& settings)
    : package_(package), settings_(settings), splats_(package.samples) {
  auto tables = std::make_unique<Tables>(
      Tables{package.samples, settings.threads, package.samples.cluster_of_sample(), {}, {}});
  for (const auto& [name, op] : package.operators) {
    tables->operators.emplace(name, std::visit([](const auto& o) { return decode(o); }, op));
  }
  for (const ProgramStep& step : package.program) {
    const auto* direct = std::get_if<DirectLightStep>(&step);
    if (direct != nullptr && direct->shadow == DirectLightStep::Shadow::kDepth) {
      tables->depths.emplace(*package.visibility, package.samples);
    }
  }
  tables_ = std::move(tables);
}

Evaluator::~Evaluator() = default;

void Evaluator::run_program(const std::function<MatrixF()>& take, SampleIrradiance& result) const {
  const MatrixF zero = MatrixF::Zero(static_cast<Eigen::Index>(package_.samples.size()), 3);
  std::map<std::string, Value> values;
  const auto apply = [&](const ApplyStep& step) {
    values[step.output] = tables_->apply(tables_->operators.at(step.op), values.at(step.input));
  };
  const auto add = [&](const AddStep& step) {
    const Value& a = values.at(step.a);
    const Value& b = values.at(step.b);
    values[step.output] = {sum(a.direct, b.direct), sum(a.indirect, b.indirect), a.layout};
  };
  for (const ProgramStep& step : package_.program) {
    if (const auto* light = std::get_if<DirectLightStep>(&step))
      values[light->output] = {take(), {}, {}};
    if (const auto* application = std::get_if<ApplyStep>(&step)) apply(*application);
    if (const auto* addition = std::get_if<AddStep>(&step)) add(*addition);
    if (const auto* reconstruct = std::get_if<ReconstructStep>(&step)) {
      const Value& value = values.at(reconstruct->input);
      result.direct = sum(zero, value.direct);
      result.indirect = sum(zero, value.indirect);
    }
  }
}

SampleIrradiance Evaluator::evaluate(std::span<const Light> lights) const {
  SampleIrradiance result;
  result.lights.assign(lights.begin(), lights.end());
  const auto take = [&] {
    MatrixF direct = MatrixF::Zero(static_cast<Eigen::Index>(package_.samples.size()), 3);
    for (const Light& light : lights) {
      result.visibility.push_back(tables_->add_light(light, settings_.area_samples, direct));
    }
    return direct;
  };
  run_program(take, result);
  return result;
}

MatrixF Evaluator::respond(const MatrixF& direct) const {
  SampleIrradiance result;
  run_program([&] { return direct; }, result);
  return result.indirect;
}

std::vector<float> Evaluator::visibility(const Light& light) const {
  MatrixF unused = MatrixF::Zero(static_cast<Eigen::Index>(package_.samples.size()), 3);
  return tables_->add_light(light, settings_.area_samples, unused);
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
                      std::span<const SplatWeight> weights,
                      const std::vector<std::vector<Vec2f>>& light_points) {
  PlayedIrradiance played;
  if (weights.empty()) return played;
  played.reached = true;
  played.indirect = interpolate(weights, irradiance.indirect);
  for (std::size_t l = 0; l < irradiance.lights.size(); ++l) {
    const float visibility = interpolate(weights, irradiance.visibility[l]);
    if (l == 0) played.visibility = visibility;
    if (!(visibility > 0.0F)) continue;
    played.direct += visibility * unshadowed_irradiance(irradiance.lights[l], light_points[l],
                                                        point.position, point.shading_normal);
  }
  return played;
}

}  // namespace

std::vector<PlayedIrradiance> Evaluator::reconstruct(const SampleIrradiance& irradiance,
                                                     std::span<const PlayPoint> points) const {
  std::vector<std::vector<Vec2f>> light_points;
  for (const Light& light : irradiance.lights) {
    light_points.push_back(light_samples(light, settings_.area_samples));
  }
  std::vector<PlayedIrradiance> played(points.size());
  parallel_for(points.size(), kPointGrain, settings_.threads,
               [&](std::size_t begin, std::size_t end) {
                 std::vector<SplatWeight> weights;
                 for (std::size_t i = begin; i < end; ++i) {
                   splats_.weights_at(points[i].position, points[i].normal, weights);
                   played[i] = play(irradiance, points[i], weights, light_points);
                 }
               });
  return played;
}

}  // namespace prt
