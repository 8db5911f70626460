// What happened to each task, for the report, the index and the trace.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "jobs/protocol.h"
#include "store/artifact.h"
#include "store/manifest.h"

namespace prt {

/// The numbers among an artifact's attributes: measured errors, ranks, counts.
nlohmann::json figures_of(const Artifact& artifact);

struct TaskHistory {
  std::string task;
  std::string stage;
  Digest key;
  Digest content;
  int rank = 0;
  bool made = false;  ///< in this run; else found
  TaskCost cost;      ///< of making it; zero where an earlier run made it and left no line
  nlohmann::json figures;
};

class History {
 public:
  /// `earlier`: the makings that the manifest told of at the start.
  explicit History(const std::vector<ManifestEntry>& earlier);

  const TaskHistory& add(const Record& record);
  /// Asks for the figures of tasks that were found, not made.
  void fill_figures(const std::function<nlohmann::json(const std::string& task)>& figures);
  [[nodiscard]] const std::vector<TaskHistory>& tasks() const { return tasks_; }
  [[nodiscard]] std::size_t made() const { return made_; }
  /// Seconds in which at least one task of an earlier run ran that this bake still uses.
  [[nodiscard]] double earlier_seconds() const;

 private:
  std::map<Digest, ManifestEntry> earlier_;  // by key
  std::vector<TaskHistory> tasks_;
  std::size_t made_ = 0;
};

ManifestEntry manifest_entry(const TaskHistory& task);

/// The bake as a Chrome trace (chrome://tracing, Perfetto): one row per rank and slot.
std::string chrome_trace(const std::vector<TaskHistory>& tasks);

}  // namespace prt
