// Runs only the stages of a bake that a test looks at.
#pragma once

#include <set>
#include <string>

#include "methods/common/inputs.h"
#include "methods/common/sampling.h"
#include "store/samples_io.h"
#include "support/in_process_bake.h"

namespace prt::test {

/// All stages up to the hemispherical rays.
inline const std::set<std::string> kSamplingAndRays = [] {
  const auto sampling = sampling_kinds();
  std::set<std::string> kinds(sampling.begin(), sampling.end());
  kinds.insert("rays");
  return kinds;
}();

/// Runs the tasks of these kinds as far as their plan goes.
inline void run_kinds(InProcessBake& bake, const Method& method,
                      const std::set<std::string>& kinds) {
  for (bool ran = true; ran;) {
    ran = false;
    for (const TaskSpec& task : method.plan(bake).tasks) {
      if (!kinds.contains(task.kind) || bake.result(task.id)) continue;
      bake.run_task(method, task);
      ran = true;
    }
  }
}

inline SampleSet samples_of(const InProcessBake& bake) {
  return get_samples(*bake.result(kSamplesTask));
}

/// The points that measured the cells.
inline CellPoints cell_points_of(const InProcessBake& bake) {
  CellPoints points;
  for (std::size_t i = 0; const auto part = bake.result(numbered("cells", i)); ++i) {
    append_cell_points(*part, points);
  }
  return points;
}

/// Senders of all samples, samples × directions.
inline std::vector<std::uint32_t> senders_of(const InProcessBake& bake, std::size_t clusters) {
  std::vector<std::uint32_t> all;
  for (std::size_t c = 0; c < clusters; ++c) {
    const auto part = bake.result(numbered("rays", c))->values<std::uint32_t>("sender");
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

}  // namespace prt::test
