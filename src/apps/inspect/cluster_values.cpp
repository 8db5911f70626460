#include "apps/inspect/cluster_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace prt {

double ClusterValues::place(double value) const {
  if (!(high > low)) return 0.5;
  return std::clamp((value - low) / (high - low), 0.0, 1.0);
}

std::string ClusterValues::text(double value) const {
  return percent ? fmt::format("{:.3g} %", 100.0 * value) : fmt::format("{:.3g}", value);
}

ClusterValues make_cluster_values(std::string title, std::vector<double> of_cluster, bool percent) {
  ClusterValues values{std::move(title), std::move(of_cluster), 0.0, 0.0, percent};
  bool any = false;
  for (double& v : values.of_cluster) {
    if (!std::isfinite(v)) continue;
    values.low = any ? std::min(values.low, v) : v;
    values.high = any ? std::max(values.high, v) : v;
    any = true;
  }
  return values;
}

ClusterValues light_function_counts(const Artifact& light_functions) {
  const auto begin = light_functions.values<std::uint32_t>("begin");
  std::vector<double> counts;
  for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
    if (begin[c + 1] < begin[c]) throw UnsoundData("light_functions: begin does not rise");
    counts.push_back(begin[c + 1] - begin[c]);
  }
  return make_cluster_values("light functions per cluster", std::move(counts), false);
}

ClusterValues transfer_errors(std::vector<double> of_cluster) {
  return make_cluster_values("relative error of compressed transfer", std::move(of_cluster), true);
}

}  // namespace prt
