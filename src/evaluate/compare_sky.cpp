#include "evaluate/compare_sky.h"

#include <array>
#include <utility>

#include "evaluate/judged.h"

namespace prt {
namespace {

/// Of a set of points: direct(i) and indirect(i) are what is played there.
template <typename Direct, typename Indirect>
SkySums sums_of(TestSet set, const Direct& direct, const Indirect& indirect) {
  SkySums sums;
  sums.direct = judge(set, &IrradianceEstimate::direct, direct).sums();
  sums.indirect = judge(set, &IrradianceEstimate::indirect, indirect).sums();
  for (IrradianceEstimate& e : set.reference) {
    for (std::size_t half = 0; half < 2; ++half) e.direct[half] += e.indirect[half];
  }
  sums.total = judge(set, &IrradianceEstimate::direct, [&](std::size_t i) -> Vec3f {
                 return direct(i) + indirect(i);
               }).sums();
  return sums;
}

Vec3f row(const MatrixF& irradiance, std::uint32_t sample) {
  return irradiance.block<1, 3>(sample, 0).transpose();
}

}  // namespace

std::uint64_t SkyErrors::not_finite() const {
  return at_samples.total.not_finite + on_surface.total.not_finite;
}

SkyErrors compare_sky(const Evaluator& player, const MatrixF& environment,
                      const TestPoints& reference) {
  const SampleIrradiance played = player.evaluate({}, environment);
  SkyErrors errors;
  errors.at_samples = sums_of(
      reference.at_samples,
      [&](std::size_t i) { return row(played.sky, reference.sample_index[i]); },
      [&](std::size_t i) { return row(played.indirect, reference.sample_index[i]); });
  std::vector<PlayPoint> points;
  for (const ReceiverPoint& p : reference.on_surface.points) {
    points.push_back({p.position, p.normal, p.normal});
  }
  const auto values = player.reconstruct(played, points);
  errors.on_surface = sums_of(
      reference.on_surface, [&](std::size_t i) { return values[i].direct; },
      [&](std::size_t i) { return values[i].indirect; });
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].reached) errors.unreached += reference.on_surface.weights[i];
  }
  return errors;
}

nlohmann::json sky_error_report(std::span<const SkyErrors> skies) {
  nlohmann::json report;
  constexpr std::array<std::pair<const char*, IrradianceSums SkySums::*>, 3> kParts = {
      {{"direct", &SkySums::direct}, {"indirect", &SkySums::indirect}, {"total", &SkySums::total}}};
  for (const auto& [name, part] : kParts) {
    std::vector<IrradianceSums> at_samples, on_surface;
    for (const SkyErrors& sky : skies) {
      at_samples.push_back(sky.at_samples.*part);
      on_surface.push_back(sky.on_surface.*part);
    }
    report[name] = to_json(irradiance_error(at_samples));
    report[name]["surface"] = to_json(irradiance_error(on_surface));
  }
  double unreached = 0.0;
  for (const SkyErrors& sky : skies) unreached += sky.unreached / static_cast<double>(skies.size());
  report["unreached_share"] = unreached;
  report["environments"] = skies.size();
  return report;
}

}  // namespace prt
