// Compares what a package plays with the path-traced reference, and makes the error report of it.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "evaluate/metrics.h"
#include "evaluate/reference.h"
#include "player/evaluator.h"

namespace prt {

/// All that one test light tells about a package. Sums pool over lights.
struct LightErrors {
  Vec3f position = Vec3f::Zero();                   ///< of the light, m
  IrradianceSums direct, indirect;                  ///< at samples
  IrradianceSums direct_surface, indirect_surface;  ///< as the player reconstructs
  IrradianceSums indirect_of_exact;  ///< at samples, were direct light at all samples exact
  std::vector<IrradianceSums> direct_by_cluster, indirect_by_cluster;  ///< at samples, as above
  VisibilitySums visibility;
  double unreached = 0.0;  ///< share of the surface that no splat reaches; counts there as unlit
  [[nodiscard]] std::uint64_t not_finite() const;
};

/// Plays the reference's light and compares. The reference's samples are those of the player's
/// package.
LightErrors compare(const Evaluator& player, const LightReference& reference);

/// Keys direct and indirect (those of to_json(IrradianceError), the same under "surface" and, for
/// indirect light of exact direct light, under "exact_direct",
/// worst_light {light, position, rel_rmse} by its own error and worst_cluster {cluster, rel_rmse,
/// error_share} by its share of the squared error of all clusters, in [0, 1]; null where there is
/// no error), visibility_error, visibility_error_soft, visibility_error_weighted, unreached_share,
/// lights.
nlohmann::json error_report(std::span<const LightErrors> lights);

/// Takes the positions in an error report from a scene of that origin to the world.
void place_in_world(nlohmann::json& report, const Vec3d& origin);

}  // namespace prt
