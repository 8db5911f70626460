// Compares what a package plays of an environment with the path-traced reference.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "evaluate/metrics.h"
#include "evaluate/reference.h"
#include "player/evaluator.h"

namespace prt {

/// Irradiance straight from the sky, what surfaces reflect of it, and both.
struct SkySums {
  IrradianceSums direct, indirect, total;
};

/// All that one environment tells about a package. Sums pool over environments.
struct SkyErrors {
  SkySums at_samples;
  SkySums on_surface;      ///< as the player reconstructs
  double unreached = 0.0;  ///< share of the surface that no splat reaches; counts there as unlit
  [[nodiscard]] std::uint64_t not_finite() const;
};

/// Plays `environment` (as Evaluator::evaluate takes it) and compares. The reference is of the same
/// environment, its samples those of the player's package.
SkyErrors compare_sky(const Evaluator& player, const MatrixF& environment,
                      const TestPoints& reference);

/// Keys direct, indirect and total (those of to_json(IrradianceError), "light" meaning environment,
/// and the same under "surface"), unreached_share, environments.
nlohmann::json sky_error_report(std::span<const SkyErrors> skies);

}  // namespace prt
