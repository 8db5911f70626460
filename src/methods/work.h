// What the stages of a bake amount to, as counts: from them and a small bake of the same scene come
// predictions. No KEY and no order of tasks depends on any of it; with a time limit, which level of
// effort is made does.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace prt {

/// Means of what finished tasks said of themselves, by stage and figure ("snapshot", "rank"). Two
/// figures are there for every stage: "tasks", and "rounds", how often the stage was gone through.
/// In the place of a stage, "options" holds the numbers among the options they were found with.
using StageFigures = std::map<std::string, std::map<std::string, double>>;

struct BakeSize {
  double samples = 0.0;
  double clusters = 0.0;
};

struct StageWork {
  std::string stage;
  double tasks = 0.0;
  double rays = 0.0;    ///< cast, shadow rays included; where paths end is not known beforehand: 0
  double work = 0.0;    ///< in any unit: proportional to seconds within one scene
  double bytes = 0.0;   ///< of all its artifacts, to within a factor that a scene sets
  double memory = 0.0;  ///< bytes that one of its tasks holds
};

}  // namespace prt
