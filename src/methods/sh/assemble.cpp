#include "methods/sh/assemble.h"

#include "bases/spherical_harmonics.h"
#include "methods/common/inputs.h"
#include "methods/common/sampling.h"
#include "methods/sh/plan.h"
#include "store/quantised_io.h"
#include "store/samples_io.h"

namespace prt::sh {

namespace {

using Result = std::function<std::shared_ptr<const Artifact>(const std::string&)>;

// Transfer from the whole sky is transfer from one sender: coefficients of an environment stand
// where a first cluster's would.
constexpr std::uint32_t kSky = 0;

ClusterTransfer factors_of(const Result& result, const std::string& part, std::size_t clusters,
                           std::uint32_t channels) {
  ClusterTransfer transfer;
  transfer.channels = channels;
  for (std::size_t c = 0; c < clusters; ++c) {
    const auto factors = result(numbered(kTransfer, c));
    QuantisedMatrix left = get_quantised(*factors, part + "_left");
    QuantisedMatrix right = get_quantised(*factors, part + "_right");
    std::vector<std::uint32_t> senders;
    if (left.cols > 0) senders.push_back(kSky);  // a cluster in the dark has none
    transfer.receivers.push_back({std::move(senders), std::move(left), std::move(right)});
  }
  return transfer;
}

}  // namespace

Package assemble_package(const Result& result, const OptionValues& options) {
  Package package;
  package.samples = get_samples(*result(kSamplesTask));
  package.provenance["method"] = "sh";
  package.provenance["options"] = nlohmann::json::object();
  for (const auto& [key, value] : options_of_results(options))
    package.provenance["options"][key] = value;
  const auto first = result(numbered(kTransfer, 0));
  if (!first) return package;
  const auto n = static_cast<std::uint32_t>(package.samples.size());
  const std::size_t clusters = package.samples.clusters();
  const auto functions = static_cast<std::uint32_t>(sh_count(first->attribute<int>("order")));
  package.spaces = {{"sky_light", Space::Kind::kEnvironmentCoefficients, functions},
                    {"sky", Space::Kind::kSampleIrradiance, n}};
  package.operators["sky"] = factors_of(result, "direct", clusters, 1);
  package.program = {EnvironmentLightStep{"sky", "sky_light", "sky"}};
  std::string seen = "sky";
  if (first->has("indirect_left")) {
    package.spaces.push_back({"sky_bounced", Space::Kind::kSampleIrradiance, n});
    package.spaces.push_back({"sky_total", Space::Kind::kSampleIrradiance, n});
    package.operators["sky_bounced"] =
        factors_of(result, "indirect", clusters, first->attribute<std::uint32_t>("channels"));
    package.program.emplace_back(ApplyStep{"sky_bounced", "sky_light", "sky_bounced"});
    package.program.emplace_back(AddStep{"sky", "sky_bounced", "sky_total"});
    seen = "sky_total";
  }
  package.program.emplace_back(ReconstructStep{seen});
  return package;
}

}  // namespace prt::sh
