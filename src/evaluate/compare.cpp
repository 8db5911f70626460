#include "evaluate/compare.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "evaluate/judged.h"

namespace prt {
namespace {

/// The same cluster by cluster; sample(i) is the sample that i was judged at.
std::vector<IrradianceSums> by_cluster(const Judged& judged, const SampleSet& samples,
                                       const std::function<std::uint32_t(std::size_t)>& sample) {
  std::vector<Judged> parts(samples.clusters());
  const auto cluster = samples.cluster_of_sample();
  for (std::size_t i = 0; i < judged.values.size(); ++i) {
    parts[cluster[sample(i)]].add(judged.values[i], judged.first[i], judged.second[i],
                                  judged.weights[i]);
  }
  std::vector<IrradianceSums> sums;
  sums.reserve(parts.size());
  for (const Judged& part : parts) sums.push_back(part.sums());
  return sums;
}

/// Direct light is known exactly and costs one ray, so every sample is asked: a few near the light
/// own the error, and a choice of points would mostly miss them.
void compare_direct(const SampleSet& samples, const SampleIrradiance& played,
                    const LightReference& reference, LightErrors& errors) {
  Judged judged;
  std::vector<ReceiverPoint> points;
  std::vector<float> visibility;
  std::vector<std::uint8_t> seen;
  const double area = std::accumulate(samples.areas.begin(), samples.areas.end(), 0.0);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Vec3f exact = Vec3f::Constant(reference.direct.at(s));
    judged.add(played.direct.block<1, 3>(static_cast<Eigen::Index>(s), 0).transpose(), exact, exact,
               static_cast<float>(samples.areas[s] / area));
    points.push_back({samples.positions[s], samples.normals[s]});
    // A light within rounding of the horizon may have no value; it is dark either way.
    const float v = played.visibility[0][s];
    visibility.push_back(v == kUnlit ? 0.0F : v);
    seen.push_back(reference.direct[s] > 0.0F ? 1 : 0);
  }
  errors.direct = judged.sums();
  errors.direct_by_cluster =
      by_cluster(judged, samples, [](std::size_t s) { return static_cast<std::uint32_t>(s); });
  errors.visibility =
      visibility_sums(points, judged.weights, reference.light.position, visibility, seen);
}

/// Indirect light at the test samples: n × 3, a row per sample.
Judged judge_indirect(const MatrixF& indirect, const LightReference& reference) {
  return judge(reference.at_samples, &IrradianceEstimate::indirect, [&](std::size_t i) -> Vec3f {
    return indirect.block<1, 3>(reference.sample_index[i], 0).transpose();
  });
}

void compare_indirect(const Evaluator& player, const SampleIrradiance& played,
                      const LightReference& reference, LightErrors& errors) {
  const Judged judged = judge_indirect(played.indirect, reference);
  errors.indirect = judged.sums();
  errors.indirect_by_cluster = by_cluster(judged, player.package().samples,
                                          [&](std::size_t i) { return reference.sample_index[i]; });
  const Eigen::Map<const VectorF> exact(reference.direct.data(),
                                        static_cast<Eigen::Index>(reference.direct.size()));
  errors.indirect_of_exact =
      judge_indirect(player.respond(exact.replicate<1, 3>()), reference).sums();
}

void compare_on_surface(const Evaluator& player, const SampleIrradiance& played,
                        const LightReference& reference, LightErrors& errors) {
  const TestSet& set = reference.on_surface;
  std::vector<PlayPoint> points;
  for (const ReceiverPoint& p : set.points) points.push_back({p.position, p.normal, p.normal});
  const auto values = player.reconstruct(played, points);
  const auto direct = [&](std::size_t i) { return values[i].direct; };
  const auto indirect = [&](std::size_t i) { return values[i].indirect; };
  errors.direct_surface = judge(set, &IrradianceEstimate::direct, direct).sums();
  errors.indirect_surface = judge(set, &IrradianceEstimate::indirect, indirect).sums();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].reached) errors.unreached += set.weights[i];
  }
}

/// The light whose own relative error is the largest.
nlohmann::json worst_light(std::span<const LightErrors> lights, IrradianceSums LightErrors::*part) {
  nlohmann::json worst = nullptr;
  double largest = 0.0;
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const IrradianceSums& sums = lights[k].*part;
    if (!(sums.squared_error > 0.0) || !(sums.squared_power > 0.0)) continue;
    const double error = std::sqrt(sums.squared_error / sums.squared_power);
    if (!(error > largest)) continue;
    largest = error;
    const Vec3f& p = lights[k].position;
    worst = {{"light", k}, {"position", {p.x(), p.y(), p.z()}}, {"rel_rmse", error}};
  }
  return worst;
}

/// The cluster in which most of the pooled squared error lies. Unbiased squares may come out
/// negative: those clusters count as without error.
nlohmann::json worst_cluster(std::span<const LightErrors> lights,
                             std::vector<IrradianceSums> LightErrors::*part) {
  if (lights.empty()) return nullptr;
  std::vector<double> error((lights[0].*part).size(), 0.0);
  std::vector<double> power(error.size(), 0.0);
  for (const LightErrors& light : lights) {
    for (std::size_t c = 0; c < error.size(); ++c) {
      error[c] += (light.*part)[c].squared_error;
      power[c] += (light.*part)[c].squared_power;
    }
  }
  double total = 0.0;
  for (const double e : error) total += std::max(0.0, e);
  const auto worst = std::ranges::max_element(error);
  if (worst == error.end() || !(*worst > 0.0) || !(total > 0.0)) return nullptr;
  const auto c = static_cast<std::size_t>(worst - error.begin());
  nlohmann::json own = nullptr;  // a cluster in the dark has no scale
  if (power[c] > 0.0) own = std::sqrt(error[c] / power[c]);
  return {{"cluster", c}, {"rel_rmse", own}, {"error_share", error[c] / total}};
}

}  // namespace

std::uint64_t LightErrors::not_finite() const {
  return direct.not_finite + indirect.not_finite + direct_surface.not_finite +
         indirect_surface.not_finite + indirect_of_exact.not_finite + visibility.not_finite;
}

LightErrors compare(const Evaluator& player, const LightReference& reference) {
  LightErrors errors;
  errors.position = reference.light.position;
  const SampleIrradiance played = player.evaluate({&reference.light, 1});
  compare_direct(player.package().samples, played, reference, errors);
  compare_indirect(player, played, reference, errors);
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
  report["indirect"]["exact_direct"] = judged(&LightErrors::indirect_of_exact);
  report["direct"]["worst_light"] = worst_light(lights, &LightErrors::direct);
  report["direct"]["worst_cluster"] = worst_cluster(lights, &LightErrors::direct_by_cluster);
  report["indirect"]["worst_light"] = worst_light(lights, &LightErrors::indirect);
  report["indirect"]["worst_cluster"] = worst_cluster(lights, &LightErrors::indirect_by_cluster);
  const VisibilityError seen = visibility_error(visibility);
  report["visibility_error"] = seen.wrong_share;
  report["visibility_error_soft"] = seen.soft;
  report["visibility_error_weighted"] = seen.weighted;
  report["unreached_share"] = unreached;
  report["lights"] = lights.size();
  return report;
}

void place_in_world(nlohmann::json& report, const Vec3d& origin) {
  if (origin == Vec3d::Zero()) return;
  for (const char* part : {"direct", "indirect"}) {
    nlohmann::json& worst = report[part]["worst_light"];
    if (worst.is_null()) continue;
    nlohmann::json& position = worst["position"];
    for (int c = 0; c < 3; ++c) position[c] = position[c].get<double>() + origin[c];
  }
}

}  // namespace prt
