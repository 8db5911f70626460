// Plans a bake: the method's tasks and those that measure the bake's error, from the artifacts that
// are there.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "apps/bake/accuracy.h"
#include "apps/bake/bake.h"
#include "apps/bake/input_cache.h"
#include "apps/bake/time_limit.h"
#include "jobs/protocol.h"
#include "store/artifact_store.h"

namespace prt {

/// Where the artifact of a finished task lies; empty while the task is not finished.
using FindResult = std::function<std::optional<TaskInput>(const std::string& task)>;

/// Thrown by planning when the artifact of a finished task cannot be trusted.
class ResultDistrusted : public std::runtime_error {
 public:
  ResultDistrusted(std::string id, const std::string& why)
      : std::runtime_error(why), task(std::move(id)) {}
  std::string task;
};

struct BakePlan {
  Plan all;                                     ///< method and evaluation together
  std::vector<std::string> evaluation_results;  ///< of BakeErrorMeter::plan; empty: none
  OptionValues options;  ///< what the results are made with: as configured, or a level of effort
  std::string prefix;    ///< of the ids of the tasks that belong to that level
  nlohmann::json accuracy = nullptr;    ///< {goal, levels, met}; null: none is asked for
  nlohmann::json time_limit = nullptr;  ///< describe_time_limit; null: there is none
  bool undecided = false;  ///< the next level hangs on a clock, and the planner has none
};

class Planner {
 public:
  /// `timed` chooses levels where there is a time limit; null: such a plan ends undecided.
  Planner(const BakeProgram& program, const Method& method, const OptionValues& options,
          const Scene& scene, const ArtifactStore& store, TimedLevels* timed = nullptr);

  /// Throws ResultDistrusted.
  BakePlan plan(const FindResult& find);
  /// Tasks whose artifacts planning has looked at: they must stay on disk.
  [[nodiscard]] const std::set<std::string>& read_tasks() const { return read_; }
  /// The artifact of a finished task, null for one that is not; throws ResultDistrusted.
  std::shared_ptr<const Artifact> read(const std::string& task, const FindResult& find);

 private:
  class Inputs;
  BakePlan plan_with(const OptionValues& options, const std::string& prefix,
                     const FindResult& find);
  BakePlan plan_level(int level, const FindResult& find);
  BakePlan plan_levels(const AccuracyGoal& goal, const FindResult& find);
  [[nodiscard]] nlohmann::json error_of(const BakePlan& plan, const FindResult& find);
  [[nodiscard]] nlohmann::json figures(const std::string& task, const FindResult& find);
  const BakeProgram& program_;
  const Method& method_;
  const OptionValues& options_;
  const Scene& scene_;
  TimedLevels* timed_;
  InputCache cache_;
  std::set<std::string> read_;
};

}  // namespace prt
