#include "methods/lb/needless.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "methods/common/inputs.h"

namespace prt::lb {

namespace {

constexpr double kLightShare = 0.1;

}  // namespace

std::vector<LeftOut> needless_visibility(const PlanInputs& inputs, std::size_t clusters) {
  std::size_t unoccluded = 0, full = 0;
  double rays = 0.0, rank = 0.0, escaped = 0.0;
  const auto& options = inputs.options();
  const int most = options.get<int>("lb.visibility_rank");
  for (std::size_t c = 0; c < clusters; ++c) {
    const auto part = inputs.result(numbered("visibility", c));
    escaped = std::max(escaped, part->attribute<double>("escaped_share"));
    if (part->attribute<int>("unoccluded") == 1) {
      ++unoccluded;
      rays += part->attribute<double>("samples") * options.get<double>("rays.directions");
    } else {
      rank += part->attribute<double>("rank");
      full += part->attribute<int>("rank") == most ? 1 : 0;
    }
  }
  std::vector<LeftOut> left_out;
  const std::size_t based = clusters - unoccluded;
  if (unoccluded > 0) {
    left_out.push_back(
        {fmt::format("visibility basis of {} of {} clusters", unoccluded, clusters),
         fmt::format("they see everything up to their walls: none of {:.0f} rays met anything "
                     "else",
                     rays)});
  }
  if (full < based) {
    left_out.push_back(
        {fmt::format("visibility functions beyond {:.1f} in the mean of {} clusters",
                     rank / static_cast<double>(based), based),
         fmt::format("up to {} are allowed: the rest has no energy, or less than a hundredth of "
                     "the error of rounding",
                     most)});
  }
  if (escaped == 0.0) {
    left_out.push_back({"escape data", "no ray escapes: light from outside never comes in"});
  }
  return left_out;
}

std::vector<LeftOut> needless_blocks(const PlanInputs& inputs, const std::string& stage,
                                     std::size_t clusters) {
  std::size_t kept = 0;
  double dropped = 0.0;
  for (std::size_t c = 0; c < clusters; ++c) {
    const auto part = inputs.result(numbered(stage, c));
    kept += part->at("senders").dims.at(0);
    dropped = std::max(dropped, part->attribute<double>("error_dropped"));
  }
  const std::size_t all = clusters * clusters;
  if (kept == all) return {};
  return {
      {fmt::format("transfer blocks of {} of {} pairs of clusters", all - kept, all),
       fmt::format("they exchange next to nothing: at most {:.1e} of a cluster's indirect light",
                   dropped)}};
}

std::vector<LeftOut> needless_light_functions(const Artifact& functions) {
  const auto needless = functions.attribute<int>("needless");
  if (needless == 0) return {};
  return {{fmt::format("{} light functions", needless),
           fmt::format("all that are too weak hold {:.1e} of the effect of direct light",
                       functions.attribute<double>("needless_effect"))}};
}

double light_tolerance(const OptionValues& options) {
  return kLightShare * options.get<double>("transport.tolerance");
}

int sufficient_bounces(double largest, double tolerance) {
  constexpr int kMost = 1000;
  int bounces = 1;
  for (double left = largest; left > tolerance && bounces < kMost; left *= largest) ++bounces;
  return bounces;
}

}  // namespace prt::lb
