#include "evaluate/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/random.h"

namespace prt {
namespace {

/// Bootstrap resamples of the lights: their standard deviation is then known to about 3 %.
constexpr int kResamples = 500;
/// The bootstrap's own random numbers; it needs no other key, for it only judges finished sums.
constexpr std::uint64_t kBootstrapSeed = 1;

double ratio_root(double error, double power) {
  if (error <= 0.0) return 0.0;  // below the noise of the references
  return power > 0.0 ? std::sqrt(error / power) : static_cast<double>(kInfinity);
}

struct Pooled {
  double error = 0.0, power = 0.0;
  void add(const IrradianceSums& s) {
    error += s.squared_error;
    power += s.squared_power;
  }
  [[nodiscard]] double rel_rmse() const { return ratio_root(error, power); }
};

/// Noise of rel_rmse: that of x = error/power by linearisation, carried through the square root.
/// Near x = 0 the root is taken at the noise itself, where it is still informative.
double reference_noise(std::span<const IrradianceSums> lights, const Pooled& pooled) {
  if (pooled.power <= 0.0) return 0.0;
  const double x = std::max(0.0, pooled.error / pooled.power);
  double variance = 0.0;
  for (const IrradianceSums& s : lights) {
    variance += s.noise_mm + 2.0 * x * s.noise_mr + x * x * s.noise_rr;
  }
  const double sigma = std::sqrt(std::max(0.0, variance)) / pooled.power;
  return sigma > 0.0 ? sigma / (2.0 * std::sqrt(std::max(x, sigma))) : 0.0;
}

double bootstrap_error(std::span<const IrradianceSums> lights) {
  if (lights.size() < 2) return 0.0;
  const std::uint64_t stream = stream_key(kBootstrapSeed, "bootstrap over lights");
  double sum = 0.0, sum_of_squares = 0.0;
  for (int i = 0; i < kResamples; ++i) {
    Random random(stream, static_cast<std::uint64_t>(i));
    Pooled pooled;
    for (std::size_t k = 0; k < lights.size(); ++k) {
      pooled.add(lights[random.below(static_cast<std::uint32_t>(lights.size()))]);
    }
    const double value = pooled.rel_rmse();
    sum += value;
    sum_of_squares += value * value;
  }
  const double mean = sum / kResamples;
  return std::sqrt(std::max(0.0, sum_of_squares / kResamples - mean * mean));
}

nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace

IrradianceSums irradiance_sums(std::span<const Vec3f> values, std::span<const Vec3f> first,
                               std::span<const Vec3f> second, std::span<const float> weights) {
  assert(values.size() == first.size() && first.size() == second.size() &&
         second.size() == weights.size());
  IrradianceSums sums;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].allFinite() || !first[i].allFinite() || !second[i].allFinite()) {
      ++sums.not_finite;
      continue;
    }
    const Vec3d e = values[i].cast<double>(), r1 = first[i].cast<double>(),
                r2 = second[i].cast<double>();
    const Vec3d mean = 0.5 * (r1 + r2), half = 0.5 * (r1 - r2);
    const double w = weights[i];
    const double hm = 2.0 * w * half.dot(e - mean), hr = 2.0 * w * half.dot(mean);
    sums.squared_error += w * (e - r1).dot(e - r2);
    sums.squared_power += w * r1.dot(r2);
    sums.noise_mm += hm * hm;
    sums.noise_mr += hm * hr;
    sums.noise_rr += hr * hr;
    sums.negative += w * static_cast<double>((e.array() < 0.0).count()) / 3.0;
  }
  return sums;
}

IrradianceError irradiance_error(std::span<const IrradianceSums> lights) {
  IrradianceError error;
  if (lights.empty()) return error;
  Pooled pooled;
  std::vector<double> single;
  for (const IrradianceSums& s : lights) {
    pooled.add(s);
    single.push_back(ratio_root(s.squared_error, s.squared_power));
    error.negative_share += s.negative / static_cast<double>(lights.size());
  }
  error.rel_rmse = pooled.rel_rmse();
  error.rel_rmse_median = quantile(single, 0.5);
  error.rel_rmse_p95 = quantile(single, 0.95);
  error.standard_error = reference_noise(lights, pooled);
  error.light_error = bootstrap_error(lights);
  return error;
}

VisibilitySums visibility_sums(std::span<const ReceiverPoint> points,
                               std::span<const float> weights, const Vec3f& position,
                               std::span<const float> visibility,
                               std::span<const std::uint8_t> traced) {
  assert(points.size() == weights.size() && points.size() == visibility.size() &&
         points.size() == traced.size());
  VisibilitySums sums;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d way = (position - points[i].position).cast<double>();
    const double squared = way.squaredNorm();
    const double cosine = points[i].normal.cast<double>().dot(way) / std::sqrt(squared);
    if (!(cosine > 0.0)) continue;
    if (!std::isfinite(visibility[i])) {
      ++sums.not_finite;
      continue;
    }
    const double w = weights[i], v = visibility[i];
    const bool seen = traced[i] != 0;
    const double difference = std::abs(v - (seen ? 1.0 : 0.0));
    if ((v >= 0.5) != seen) sums.wrong += w;
    sums.soft += w * difference;
    sums.weight += w;
    sums.irradiance_soft += w * difference * cosine / squared;
    sums.irradiance += w * cosine / squared;
  }
  return sums;
}

VisibilityError visibility_error(std::span<const VisibilitySums> lights) {
  VisibilitySums all;
  for (const VisibilitySums& s : lights) {
    all.wrong += s.wrong;
    all.soft += s.soft;
    all.weight += s.weight;
    all.irradiance_soft += s.irradiance_soft;
    all.irradiance += s.irradiance;
  }
  if (all.weight <= 0.0) return {};
  return {all.wrong / all.weight, all.soft / all.weight, all.irradiance_soft / all.irradiance};
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double share = place - static_cast<double>(below);
  // An infinite neighbour counts only where it has a share: 0 · infinity is no number.
  return share == 0.0 ? values[below] : (1.0 - share) * values[below] + share * values[above];
}

nlohmann::json to_json(const IrradianceError& error) {
  return {{"rel_rmse", finite_or_null(error.rel_rmse)},
          {"rel_rmse_light",
           {{"median", finite_or_null(error.rel_rmse_median)},
            {"p95", finite_or_null(error.rel_rmse_p95)}}},
          {"standard_error", finite_or_null(error.standard_error)},
          {"light_error", finite_or_null(error.light_error)},
          {"negative_share", error.negative_share}};
}

}  // namespace prt
