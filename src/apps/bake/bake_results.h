// What a finished bake leaves beside its artifacts: package, index, report, completion marker.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bake/history.h"
#include "apps/bake/planner.h"
#include "apps/bake/prediction.h"
#include "apps/config/config.h"
#include "store/bake_folder.h"

namespace prt {

/// Name of the completion marker in the bake's folder: there exactly while package, index and
/// report belong to a finished bake. mpirun's exit code says nothing after a lost rank; this does.
inline constexpr const char* kCompleteName = "complete.json";

struct BakeFacts {
  const BakeProgram& program;
  const BakeConfig& config;
  const Scene& scene;
  std::string isa;
  std::vector<std::string> hosts;  ///< one per rank
  int threads = 1;                 ///< of all ranks
  int ranks = 1;
  double began = 0.0;                          ///< when this run began, by program.clock
  const BakePrediction* prediction = nullptr;  ///< null: none was made
};

using ReadResult = std::function<std::shared_ptr<const Artifact>(const std::string& task)>;

/// Assembles the package and writes whatever is new; a second call with the same artifacts changes
/// nothing. Each file is replaced whole.
void write_results(const BakeFacts& facts, const BakePlan& plan, const ReadResult& result,
                   const History& history, BakeFolder& folder, FileSystem& fs);

void write_trace(FileSystem& fs, const std::filesystem::path& file, const History& history);

}  // namespace prt
