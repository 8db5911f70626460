// One figure per cluster, as pictures and reports show it.
#pragma once

#include <string>
#include <vector>

#include "domains/samples.h"
#include "store/artifact.h"

namespace prt {

struct ClusterValues {
  std::string title;
  std::vector<double> of_cluster;  ///< NaN: not known
  double low = 0.0;                ///< of the colour scale
  double high = 0.0;
  bool percent = false;  ///< shown as per cent, else as a count

  /// Place on the colour scale, in [0, 1].
  [[nodiscard]] double place(double value) const;
  /// "12" or "1.27 %".
  [[nodiscard]] std::string text(double value) const;
};

/// Scale from the least to the greatest value that is known; values that are not finite are not.
ClusterValues make_cluster_values(std::string title, std::vector<double> of_cluster, bool percent);

/// Number of light functions of each cluster, from the artifact "light_functions". Throws
/// UnsoundData.
ClusterValues light_function_counts(const Artifact& light_functions);

/// Measured relative error of each cluster's transfer; see make_cluster_values.
ClusterValues transfer_errors(std::vector<double> of_cluster);

}  // namespace prt
