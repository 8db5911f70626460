// report.json and report.html: what was made, what was left out and why, what it took and how wrong
// it is. The only results, beside the manifest, that hold time and host.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/bake/cpu_share.h"
#include "apps/bake/history.h"
#include "apps/bake/planner.h"
#include "apps/bake/prediction.h"
#include "apps/bake/report_pictures.h"
#include "apps/config/config.h"
#include "methods/method.h"

namespace prt {

/// What the report tells beside the tasks' own history.
struct ReportFacts {
  const BakeConfig& config;
  const Scene& scene;
  const BakePlan& plan;
  nlohmann::json error;  ///< measured error of the bake; null: not measured
  std::string package;   ///< file name
  std::uint64_t package_bytes = 0;
  Digest package_content;
  double wall_seconds = 0.0;  ///< of this run
  double cpu_seconds = 0.0;   ///< of this run, all ranks' tasks
  int ranks = 1;
  std::vector<std::string> hosts;  ///< one per rank
  int threads = 1;                 ///< of all ranks together
  std::string isa;
  const BakePrediction* prediction = nullptr;  ///< made before the bake; null: none was
  nlohmann::json survey;                       ///< survey_scene(); null where there is none
};

/// [x, y, z] of Scene::origin, m.
nlohmann::json origin_of(const Scene& scene);

nlohmann::json make_report(const ReportFacts& facts, const History& history);

/// A self-contained page that shows the same, with pictures, and with `budget` (rows of what finer
/// settings bring, budget.json) where it is an object.
std::string report_page(const nlohmann::json& report, const std::vector<ReportPicture>& pictures,
                        const nlohmann::json& budget);

}  // namespace prt
