#include "evaluate/compare.h"

#include <algorithm>
#include <functional>

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

void compare_at_samples(const SampleIrradiance& played, const LightReference& reference,
                        LightErrors& errors) {
  const auto at = [&](const MatrixF& irradiance) {
    return [&](std::size_t i) -> Vec3f {
      return irradiance.block<1, 3>(reference.sample_index[i], 0).transpose();
    };
  };
  errors.direct = sums_of(reference.at_samples, &IrradianceEstimate::direct, at(played.direct));
  errors.indirect =
      sums_of(reference.at_samples, &IrradianceEstimate::indirect, at(played.indirect));
  std::vector<float> visibility;
  for (const std::uint32_t s : reference.sample_index) {
    // A light within rounding of the horizon may have no value; it is dark either way.
    const float v = played.visibility[0][s];
    visibility.push_back(v == kUnlit ? 0.0F : v);
  }
  errors.visibility =
      visibility_sums(reference.at_samples.points, reference.at_samples.weights,
                      reference.light.position, visibility, reference.traced_visibility);
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
  compare_at_samples(played, reference, errors);
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
