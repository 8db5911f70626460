// The tasks of the method, by kind. Inputs are listed in the order each expects them. In a scene of
// several regions "windows" follows (scene_part.h), and where inputs say snapshot/* or the like,
// the clusters are those of the region's window; for light_functions they are the region's own, and
// light_basis reads the lights of all regions in whose windows its cluster is.
#pragma once

#include "base/error.h"
#include "methods/method.h"
#include "transport/gather.h"

namespace prt::lb {

/// rays/c, samples → quantised depth mean, basis, coefficients (LB §4.2), or walls where a cluster
/// sees everything up to them.
Artifact run_visibility(const TaskSpec& task, const TaskReader& reader);

/// samples → positions of example lights (LB §4.3.1).
Artifact run_lights(const TaskSpec& task, const TaskReader& reader);
/// samples, albedo, rays/c, lights/* → basis of direct light on a cluster, by effect.
Artifact run_light_basis(const TaskSpec& task, const TaskReader& reader);
/// samples, light_basis/* → all clusters' functions side by side (bundle).
Artifact run_light_functions(const TaskSpec& task, const TaskReader& reader);

/// samples, light_functions of regions ("from"), windows → those of a window, or of the whole
/// scene.
Artifact run_window_functions(const TaskSpec& task, const TaskReader& reader);

/// samples, albedo, rays/c, light_functions → basis of once-gathered light on a cluster.
Artifact run_snapshot(const TaskSpec& task, const TaskReader& reader);
/// samples, snapshot/* → all clusters' snapshot bases side by side (bundle).
Artifact run_snapshot_functions(const TaskSpec& task, const TaskReader& reader);
/// samples, albedo, rays/c, snapshot_functions → one cluster's rows of the reduced operator.
Artifact run_galerkin(const TaskSpec& task, const TaskReader& reader);
/// snapshot/*, galerkin/* (none for two bounces) → solution of one channel's reduced system for
/// every light function.
Artifact run_solve(const TaskSpec& task, const TaskReader& reader);
/// samples, rays/c → near entries of one cluster's samples.
Artifact run_near(const TaskSpec& task, const TaskReader& reader);
/// samples, albedo, rays/c, light_functions, near/*[, snapshot_functions, solve/*] → compressed
/// transfer but for the near series.
Artifact run_transfer(const TaskSpec& task, const TaskReader& reader);
/// samples, albedo, rays/c, probes of transfer/* → residual of the transport equation.
Artifact run_residual(const TaskSpec& task, const TaskReader& reader);

/// samples, light_functions, cells/* → transfer of one sender cluster by photons (LB §4.3.2).
Artifact run_photons(const TaskSpec& task, const TaskReader& reader);
/// samples, light_functions, photons/* → compressed transfer of one receiver cluster.
Artifact run_photon_transfer(const TaskSpec& task, const TaskReader& reader);

/// Runs a step that finds no sound answer where the scene's albedos allow none: that is the user's
/// to mend, and no broken artifact.
template <typename Step>
auto blaming_the_scene(const Step& step) {
  try {
    return step();
  } catch (const UnsoundData& e) {
    throw UserError(std::string("scene: ") + e.what());
  }
}

/// Light functions of all clusters as stored by run_light_functions: functions scaled by the
/// typical size of their coefficients, and the projections onto them.
struct LightFunctions {
  ClusterFunctions functions;  ///< values: samples × k
  MatrixF projections;  ///< samples × k: coefficient k of a cluster = Σ_s projections(s,k)·E(s)
};
std::shared_ptr<const ClusterFunctions> shared_functions(const TaskReader& reader, std::size_t i);
LightFunctions get_light_functions(const Artifact& artifact);

/// The compression that ends every transfer task.
struct TransferCompression {
  int bits = 8;
  int rank = 50;
  double tolerance = 1e-2;
};
/// Coefficients of the example lights in the light functions, functions × lights: what light looks
/// like here. Inputs as for shared_functions.
std::shared_ptr<const MatrixF> shared_light_coefficients(const TaskReader& reader, std::size_t i);

/// Transfer of one colour channel into a receiver cluster, n_r × all functions, as the sum of
/// once + further·solution. Multiplying it out would be most of the work of a big scene and is
/// never needed.
struct ChannelTransfer {
  MatrixF once;                             ///< n_r × functions
  MatrixF further;                          ///< n_r × unknowns
  std::shared_ptr<const MatrixF> solution;  ///< unknowns × functions; null: there is none
  /// rows·transfer: rows.rows() × functions.
  [[nodiscard]] MatrixF projected(const MatrixF& rows) const;
};

/// Matrices of equal height next to each other.
MatrixF side_by_side(const std::vector<MatrixF>& parts);

/// Compresses transfer into one receiver cluster (a part per channel) so that the light that
/// typical coefficients (functions × lights) cause is kept best, and measures on them what each
/// step costs. `fields`: that light, transfer·typical, n_r × lights per channel.
Artifact compress_transfer(const std::vector<ChannelTransfer>& transfer,
                           const std::vector<MatrixF>& fields, const VectorF& areas,
                           const std::vector<std::uint32_t>& function_begin, const MatrixF& typical,
                           const TransferCompression& settings);

}  // namespace prt::lb
