// The runtime package: spaces, operators and a straight-line program over them, with the scene that
// they light. One valid glTF 2.0 binary on disk (package/read.h, package/write.h).
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "bases/depth_basis.h"
#include "domains/directions.h"
#include "domains/samples.h"
#include "operators/blocks.h"
#include "scene/scene.h"

namespace prt {

/// Compressed depth buffers of one cluster: z ≈ mean + coefficients · basis (Leonhardt & Bohn, eq.
/// 9). A cluster that sees everything up to the walls of a convex space has rank 0 and an empty
/// mean: there what is within its walls is visible.
struct DepthBlock {
  QuantisedMatrix mean;          ///< 1 × d, or 0 × 0
  QuantisedMatrix basis;         ///< k × d
  QuantisedMatrix coefficients;  ///< n_c × k
  MatrixF walls{};               ///< w × 4, see bases/depth_basis.h; none beside a mean
};

/// More directions than this are taken for a damaged file.
inline constexpr int kMaxDirections = 65536;

/// Depth-buffer visibility for all samples.
struct DepthVisibility {
  int directions = 0;  ///< d, see HemisphereDirections
  float bound = 0.0F;  ///< m, see bases/depth_basis.h
  float bias = 0.07F;  ///< relative distance bias of the test
  std::vector<DepthBlock> clusters;
};

/// A coefficient vector with a meaning.
struct Space {
  enum class Kind {
    kSampleIrradiance,
    kClusterCoefficients,
    kEnvironmentCoefficients  ///< order² spherical harmonics of radiance (EnvironmentLightStep)
  };
  std::string name;
  Kind kind = Kind::kSampleIrradiance;
  std::uint32_t dimension = 0;  ///< per colour channel
};

using PackageOperator = std::variant<ClusterProjection, ClusterTransfer, NearTransfer>;

/// Steps name spaces and operators; each writes `output`. Type rules are checked by validate().
struct DirectLightStep {  ///< lights → irradiance at samples, shadowed by `visibility`
  std::string output;
  enum class Shadow { kNone, kDepth } shadow = Shadow::kDepth;
};
/// Light from infinitely far away, as coefficients of real spherical harmonics
/// (bases/spherical_harmonics.h, directions in the scene's world), and the direct irradiance at
/// samples that `op`, a transfer from one sender, makes of it: its coefficients stand where the
/// first cluster's would, and no other cluster has any.
struct EnvironmentLightStep {
  std::string op;
  std::string coefficients;  ///< written: the environment's, order² per channel
  std::string output;        ///< written: irradiance at samples
};
struct ApplyStep {
  std::string op, input, output;
};
struct AddStep {
  std::string a, b, output;
};
struct ReconstructStep {  ///< irradiance at samples → irradiance anywhere, by splats
  std::string input;
};
using ProgramStep =
    std::variant<DirectLightStep, EnvironmentLightStep, ApplyStep, AddStep, ReconstructStep>;

struct Package {
  Scene scene;
  SampleSet samples;
  std::optional<DepthVisibility> visibility;
  std::vector<Space> spaces;
  std::map<std::string, PackageOperator> operators;
  std::vector<ProgramStep> program;
  nlohmann::json provenance =
      nlohmann::json::object();  ///< method, parameters, version; no time or host
  nlohmann::json error =
      nlohmann::json::object();  ///< measured error (design §7), as prt_eval prints it
};

/// Order of the environment that a program takes; 0: none.
int environment_order(const Package& package);
/// Whether a program takes lights.
bool has_direct_light(const Package& package);
/// Throw UserError, with what to bake, where a program takes no environment, or no lights.
void require_environment(const Package& package, const std::string& file_name);
void require_direct_light(const Package& package, const std::string& file_name);
/// A space of so many environment coefficients laid out as a projection's would be: first
/// coefficient of each cluster, and their number.
std::vector<std::uint32_t> environment_layout(std::uint32_t coefficients, std::size_t clusters);

/// Throws UserError with a reason unless shapes, indices, names and the program fit together.
void validate(const Package& package, const std::string& file_name);

}  // namespace prt
