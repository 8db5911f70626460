// prt_inspect --image curves.
#pragma once

#include <string>
#include <vector>

#include "apps/inspect/bake_reader.h"

namespace prt {

/// One plot with a line per cluster; values fall, over their order, and share a logarithmic axis.
struct CurvePlot {
  std::string title;
  std::vector<std::vector<double>> lines;  ///< values that are not positive end a line's drawing
};

/// Plots side by side as SVG.
std::string curves_svg(const std::vector<CurvePlot>& plots);

/// What hangs on each light function and each visibility basis function, by cluster, as SVG. Throws
/// UserError if the artifacts are not there.
std::string draw_curves(const BakeReader& bake);

}  // namespace prt
