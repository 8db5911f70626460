// What every rank makes for itself before it can compute.
#pragma once

#include <string>

namespace prt::scaling {

struct RankSetUp {
  double triangles = 0.0;
  double area = 0.0;  ///< of all triangles, m²
  double samples = 0.0;
  double caster_seconds = 0.0;  ///< building the ray caster, CPU
  double search_seconds = 0.0;  ///< of the neighbour search where rays hit everything, CPU
};

/// Makes both for the scene and samples of a package, and looks at the clock.
RankSetUp measure_set_up(const std::string& package_file);

}  // namespace prt::scaling
