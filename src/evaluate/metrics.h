// What "error" means: sums over points that pool over lights, and the figures made of them.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "transport/path_tracer.h"

namespace prt {

/// Sums of one light over its test points, all channels. E is the irradiance judged, r1 and r2 two
/// independent unbiased references of it, m = E − (r1+r2)/2, h = (r1−r2)/2, r̄ = (r1+r2)/2; w is the
/// point's share of the area. (E−r1)(E−r2) and r1·r2 have no bias from the noise of r1 and r2, and
/// with normal noise (2 h·m)² has the variance of Σ_c (E−r1)(E−r2) as its mean.
struct IrradianceSums {
  double squared_error = 0.0;    ///< Σ w (E−r1)·(E−r2)
  double squared_power = 0.0;    ///< Σ w r1·r2
  double noise_mm = 0.0;         ///< Σ (2 w h·m)²
  double noise_mr = 0.0;         ///< Σ (2 w)² (h·m)(h·r̄)
  double noise_rr = 0.0;         ///< Σ (2 w h·r̄)²
  double negative = 0.0;         ///< Σ w over values E < 0, a third for each channel
  std::uint64_t not_finite = 0;  ///< points left out because E or a reference is not finite
};

/// values.size() == first.size() == second.size() == weights.size(); W/m²; weights sum to 1.
IrradianceSums irradiance_sums(std::span<const Vec3f> values, std::span<const Vec3f> first,
                               std::span<const Vec3f> second, std::span<const float> weights);

/// Figures of one kind of irradiance over all lights.
struct IrradianceError {
  double rel_rmse = 0.0;         ///< pooled: sqrt(Σ squared_error / Σ squared_power)
  double rel_rmse_median = 0.0;  ///< over single lights
  double rel_rmse_p95 = 0.0;
  double standard_error = 0.0;  ///< of rel_rmse, from the noise of the references
  double light_error = 0.0;     ///< of rel_rmse, from the choice of lights (bootstrap)
  double negative_share = 0.0;  ///< of the values, by area
};

/// A light without irradiance anywhere has error 0 if the values are 0 as well, else infinity.
IrradianceError irradiance_error(std::span<const IrradianceSums> lights);

/// Sums of one light over the sample points that face it.
struct VisibilitySums {
  double wrong = 0.0;            ///< Σ w [v >= ½ ≠ v_ref]
  double soft = 0.0;             ///< Σ w |v − v_ref|
  double weight = 0.0;           ///< Σ w
  double irradiance_soft = 0.0;  ///< Σ w |v − v_ref| cosθ/r²
  double irradiance = 0.0;       ///< Σ w cosθ/r²
  std::uint64_t not_finite = 0;  ///< points whose v is not finite
};

/// visibility[i] in [0, 1] is the soft test's answer at point i, traced[i] 1 if the light is seen.
/// Point light at `position`; points that face away do not count.
VisibilitySums visibility_sums(std::span<const ReceiverPoint> points,
                               std::span<const float> weights, const Vec3f& position,
                               std::span<const float> visibility,
                               std::span<const std::uint8_t> traced);

struct VisibilityError {
  double wrong_share = 0.0;  ///< visibility_error
  double soft = 0.0;         ///< visibility_error_soft
  double weighted = 0.0;     ///< visibility_error_weighted
};
VisibilityError visibility_error(std::span<const VisibilitySums> lights);

/// Quantile q in [0, 1] by linear interpolation between order statistics; 0 for no values.
double quantile(std::vector<double> values, double q);

/// Keys rel_rmse, rel_rmse_light {median, p95}, standard_error, light_error, negative_share.
/// Infinite figures (nothing to compare with) become null.
nlohmann::json to_json(const IrradianceError& error);

}  // namespace prt
