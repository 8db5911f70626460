#include "evaluate/compare.h"

#include <algorithm>
#include <functional>
#include <numeric>

namespace prt {
namespace {

/// Judges values against the reference's `part` (direct or indirect).
IrradianceSums sums_of(const TestSet& set, std::array<Vec3f, 2> IrradianceEstimate::*part,
                       const std::function<Vec3f(std::size_t)>& value) {
  std::vector<Vec3f> values, first, second;
  for (std::size_t i = 0; i < set.points.size(); ++i) {
    values.push_back(value(i));
    first.push_back((set.reference[i].*part)[0]);
    second.push_back((set.reference[i].*part)[1]);
  }
  return irradiance_sums(values, first, second, set.weights);
}

/// Direct light is known exactly and costs one ray, so every sample is asked: a few near the light
/// own the error, and a choice of points would mostly miss them.
void compare_direct(const SampleSet& samples, const SampleIrradiance& played,
                    const LightReference& reference, LightErrors& errors) {
  std::vector<Vec3f> values, exact;
  std::vector<ReceiverPoint> points;
  std::vector<float> weights, visibility;
  std::vector<std::uint8_t> seen;
  const double area = std::accumulate(samples.areas.begin(), samples.areas.end(), 0.0);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    values.emplace_back(played.direct.block<1, 3>(static_cast<Eigen::Index>(s), 0).transpose());
    exact.emplace_back(Vec3f::Constant(reference.direct.at(s)));
    points.push_back({samples.positions[s], samples.normals[s]});
    weights.push_back(static_cast<float>(samples.areas[s] / area));
    // A light within rounding of the horizon may have no value; it is dark either way.
    const float v = played.visibility[0][s];
    visibility.push_back(v == kUnlit ? 0.0F : v);
    seen.push_back(reference.direct[s] > 0.0F ? 1 : 0);
  }
  errors.direct = irradiance_sums(values, exact, exact, weights);
  errors.visibility = visibility_sums(points, weights, reference.light.position, visibility, seen);
}

void compare_indirect(const SampleIrradiance& played, const LightReference& reference,
                      LightErrors& errors) {
  errors.indirect =
      sums_of(reference.at_samples, &IrradianceEstimate::indirect, [&](std::size_t i) -> Vec3f {
        return played.indirect.block<1, 3>(reference.sample_index[i], 0).transpose();
      });
}

void compare_on_surface(const Evaluator& player, const SampleIrradiance& played,
                        const LightReference& reference, LightErrors& errors) {
  const TestSet& set = reference.on_surface;
  std::vector<PlayPoint> points;
  for (const ReceiverPoint& p : set.points) points.push_back({p.position, p.normal, p.normal});
  const auto values = player.reconstruct(played, points);
  errors.direct_surface =
      sums_of(set, &IrradianceEstimate::direct, [&](std::size_t i) { return values[i].direct; });
  errors.indirect_surface = sums_of(set, &IrradianceEstimate::indirect,
                                    [&](std::size_t i) { return values[i].indirect; });
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].reached) errors.unreached += set.weights[i];
  }
}

}  // namespace

std::uint64_t LightErrors::not_finite() const {
  return direct.not_finite + indirect.not_finite + direct_surface.not_finite +
         indirect_surface.not_finite + visibility.not_finite;
}

LightErrors compare(const Evaluator& player, const LightReference& reference) {
  LightErrors errors;
  const SampleIrradiance played = player.evaluate({&reference.light, 1});
  compare_direct(player.package().samples, played, reference, errors);
  compare_indirect(played, reference, errors);
  compare_on_surface(player, played, reference, errors);
  return errors;
}

nlohmann::json error_report(std::span<const LightErrors> lights) {
  const auto judged = [&](IrradianceSums LightErrors::*part) {
    std::vector<IrradianceSums> sums;
    for (const LightErrors& light : lights) sums.push_back(light.*part);
    return to_json(irradiance_error(sums));
  };
  std::vector<VisibilitySums> visibility;
  double unreached = 0.0;
  for (const LightErrors& light : lights) {
    visibility.push_back(light.visibility);
    unreached += light.unreached / static_cast<double>(lights.size());
  }
  nlohmann::json report;
  report["direct"] = judged(&LightErrors::direct);
  report["direct"]["surface"] = judged(&LightErrors::direct_surface);
  report["indirect"] = judged(&LightErrors::indirect);
  report["indirect"]["surface"] = judged(&LightErrors::indirect_surface);
  const VisibilityError seen = visibility_error(visibility);
  report["visibility_error"] = seen.wrong_share;
  report["visibility_error_soft"] = seen.soft;
  report["visibility_error_weighted"] = seen.weighted;
  report["unreached_share"] = unreached;
  report["lights"] = lights.size();
  return report;
}

}  // namespace prt
