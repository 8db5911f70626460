// What is in a bake, as tables by stage and by cluster.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/inspect/bake_reader.h"

namespace prt {

struct StageRow {
  std::string stage;
  std::size_t tasks = 0;
  std::size_t missing = 0;  ///< artifacts that are not kept
  std::uint64_t bytes = 0;  ///< of the artifacts that are there
  double seconds = 0.0;     ///< wall, of all tasks
  double cpu_seconds = 0.0;
};

/// What one stage measured on a cluster; attributes that the artifact does not have are null.
struct ClusterFigures {
  nlohmann::json rank, energy, error;
};

struct ClusterRow {
  std::int64_t cluster = 0;
  std::int64_t samples = 0;
  std::uint64_t bytes = 0;  ///< of all its artifacts
  double seconds = 0.0;
  std::map<std::string, ClusterFigures> figures;  ///< by stage
};

struct BakeTables {
  std::string identity;
  std::vector<StageRow> stages;            ///< in the order they were first finished
  std::vector<ClusterRow> clusters;        ///< ascending
  std::vector<std::string> figure_stages;  ///< stages of `figures`, in the order of `stages`
  std::size_t unreadable = 0;              ///< artifacts whose figures cannot be trusted
  nlohmann::json report;                   ///< report.json of the bake, null if there is none
};

BakeTables make_tables(const BakeReader& bake);
std::string to_text(const BakeTables& tables);
nlohmann::json to_json(const BakeTables& tables);

}  // namespace prt
