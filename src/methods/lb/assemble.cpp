#include "methods/lb/assemble.h"

#include "methods/common/inputs.h"
#include "methods/common/sampling.h"
#include "methods/lb/near.h"
#include "methods/lb/plan.h"
#include "methods/lb/tasks.h"
#include "store/quantised_io.h"
#include "store/samples_io.h"

namespace prt::lb {

namespace {

using Result = std::function<std::shared_ptr<const Artifact>(const std::string&)>;

// Coefficients multiply everything after them: 16 bits cost 2 bytes per function and sample.
constexpr int kProjectionBits = 16;

DepthVisibility visibility_of(const Result& result, std::size_t clusters,
                              const OptionValues& options) {
  DepthVisibility visibility;
  visibility.directions = options.get<int>("rays.directions");
  visibility.bias = options.get<float>("lb.distance_bias");
  for (std::size_t c = 0; c < clusters; ++c) {
    const auto part = result(numbered("visibility", c));
    visibility.bound = part->attribute<float>("bound");
    visibility.clusters.push_back({get_quantised(*part, "mean"), get_quantised(*part, "basis"),
                                   get_quantised(*part, "coefficients"),
                                   part->has("walls") ? part->matrix("walls") : MatrixF()});
  }
  return visibility;
}

ClusterProjection projection_of(const LightFunctions& light, const SampleSet& samples) {
  ClusterProjection projection;
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const MatrixF block =
        light.projections
            .block(samples.cluster_begin[c], 0, samples.cluster_size(c), light.functions.of(c))
            .transpose();
    projection.blocks.push_back(quantise(block, kProjectionBits).matrix);
  }
  return projection;
}

/// Transfer artifacts of the last round: the highest of "transfer", "transfer-2", ... that there
/// is. Plan::results names the last round alone, so there may be gaps below it.
std::string transfer_stage(const Result& result, const OptionValues& options) {
  if (options.get<std::string>("lb.solver") == "photons") return "photon_transfer";
  std::string stage = "transfer";
  for (int round = 2; round <= kMostRounds; ++round) {
    const std::string later = "transfer-" + std::to_string(round);
    if (result(numbered(later, 0))) stage = later;
  }
  return stage;
}

ClusterTransfer transfer_of(const Result& result, const std::string& stage, std::size_t clusters) {
  ClusterTransfer transfer;
  for (std::size_t c = 0; c < clusters; ++c) {
    const auto part = result(numbered(stage, c));
    transfer.channels = part->attribute<std::uint32_t>("channels");
    transfer.receivers.push_back({part->vector<std::uint32_t>("senders"),
                                  get_quantised(*part, "left"), get_quantised(*part, "right")});
  }
  return transfer;
}

/// Near transfer of all clusters; without entries where none was made.
NearTransfer near_of(const Result& result, const SampleSet& samples, std::uint32_t channels) {
  NearTransfer near;
  near.channels = channels;
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const auto part = result(numbered("near", c));
    if (!part) return {};
    append_near(*part, near);
  }
  const MatrixF albedo = result(kAlbedoTask)->matrix("albedo");
  for (Eigen::Index s = 0; s < albedo.rows(); ++s) {
    for (Eigen::Index c = 0; c < near.channels; ++c)
      near.albedo.push_back(pack_share(albedo(s, c)));
  }
  return near;
}

/// near = N·(e + N·(e + …)), as many times as transfer leaves out: the steps that make space "near"
/// from "direct".
void add_near_steps(Package& package, int bounces) {
  const auto n = static_cast<std::uint32_t>(package.samples.size());
  const auto space = [&](std::string name) {
    package.spaces.push_back({name, Space::Kind::kSampleIrradiance, n});
    return name;
  };
  std::string sent = "direct";
  for (int bounce = 1; bounce < bounces; ++bounce) {
    const std::string received = space("near-" + std::to_string(bounce));
    const std::string both = space("direct+near-" + std::to_string(bounce));
    package.program.emplace_back(ApplyStep{"near", sent, received});
    package.program.emplace_back(AddStep{"direct", received, both});
    sent = both;
  }
  package.program.emplace_back(ApplyStep{"near", sent, space("near")});
}

}  // namespace

Package assemble_package(const Result& result, const OptionValues& options) {
  Package package;
  package.samples = get_samples(*result(kSamplesTask));
  const auto n = static_cast<std::uint32_t>(package.samples.size());
  const std::size_t clusters = package.samples.clusters();
  package.visibility = visibility_of(result, clusters, options);
  const std::string stage = transfer_stage(result, options);
  const bool lit = result(numbered(stage, 0)) != nullptr;

  package.spaces = {{"direct", Space::Kind::kSampleIrradiance, n}};
  package.program = {DirectLightStep{"direct", DirectLightStep::Shadow::kDepth}};
  if (lit) {
    const LightFunctions light = get_light_functions(*result("light_functions"));
    const auto first = result(numbered(stage, 0));
    NearTransfer near =
        near_of(result, package.samples, first->attribute<std::uint32_t>("channels"));
    const bool has_near = !near.senders.empty();
    const std::string far = has_near ? "far" : "indirect";
    package.spaces.push_back({"light", Space::Kind::kClusterCoefficients, light.functions.count()});
    package.spaces.push_back({"indirect", Space::Kind::kSampleIrradiance, n});
    package.spaces.push_back({"total", Space::Kind::kSampleIrradiance, n});
    package.operators["project"] = projection_of(light, package.samples);
    package.operators["transfer"] = transfer_of(result, stage, clusters);
    package.program.emplace_back(ApplyStep{"project", "direct", "light"});
    package.program.emplace_back(ApplyStep{"transfer", "light", far});
    if (has_near) {
      package.spaces.push_back({"far", Space::Kind::kSampleIrradiance, n});
      package.operators["near"] = std::move(near);
      add_near_steps(package, first->attribute<int>("near_bounces"));
      package.program.emplace_back(AddStep{"near", "far", "indirect"});
    }
    package.program.emplace_back(AddStep{"direct", "indirect", "total"});
  }
  package.program.emplace_back(ReconstructStep{lit ? "total" : "direct"});
  package.provenance["method"] = "lb";
  package.provenance["options"] = nlohmann::json::object();
  for (const auto& [key, value] : options_of_results(options))
    package.provenance["options"][key] = value;
  return package;
}

}  // namespace prt::lb
