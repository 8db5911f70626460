// A method: one paper's way to precompute light transport, as pure functions. It plans tasks, runs
// one, and assembles its part of the package. It knows no MPI, clock, path or global.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "jobs/task.h"
#include "methods/options.h"
#include "methods/work.h"
#include "package/package.h"
#include "scene/ray_caster.h"
#include "store/artifact.h"

namespace prt {

/// Objects shared by the tasks of one process (decoded samples, neighbour grids), by name. A value
/// must be a pure function of its name. Thread-safe; a value is made once.
class Memo {
 public:
  template <typename T>
  std::shared_ptr<const T> get(const std::string& name,
                               const std::function<std::shared_ptr<T>()>& make) {
    return std::static_pointer_cast<const T>(
        get_any(name, [&] { return std::shared_ptr<void>(make()); }));
  }
  /// Forgets all values nobody holds.
  void trim();

 private:
  struct Slot {
    std::mutex mutex;
    std::shared_ptr<void> value;
  };
  std::shared_ptr<void> get_any(const std::string& name,
                                const std::function<std::shared_ptr<void>()>& make);
  std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<Slot>> slots_;
};

/// What a running task may look at.
class TaskReader {
 public:
  virtual ~TaskReader() = default;
  /// The scene; a task reads only the parts it named in TaskSpec::scene_parts.
  [[nodiscard]] virtual const Scene& scene() const = 0;
  [[nodiscard]] virtual const RayCaster& ray_caster() const = 0;
  /// Artifact of input `i` (its place in TaskSpec::inputs), verified.
  [[nodiscard]] virtual std::shared_ptr<const Artifact> input(std::size_t i) const = 0;
  /// Content hash of input i: a name for Memo.
  [[nodiscard]] virtual Digest input_content(std::size_t i) const = 0;
  [[nodiscard]] virtual Memo& memo() const = 0;
  /// True once the bake was asked to stop: a long loop then throws Interrupted.
  [[nodiscard]] virtual bool stop_requested() const = 0;
};

/// What planning may look at: options, the scene, and the artifacts of tasks that are done.
class PlanInputs {
 public:
  virtual ~PlanInputs() = default;
  [[nodiscard]] virtual const Scene& scene() const = 0;
  [[nodiscard]] virtual const OptionValues& options() const = 0;
  /// The artifact of a finished task, or null while it is not finished.
  [[nodiscard]] virtual std::shared_ptr<const Artifact> result(
      const std::string& task_id) const = 0;
};

/// What the planner decided not to make, and why.
struct LeftOut {
  std::string what, reason;
};

struct Plan {
  std::vector<TaskSpec> tasks;       ///< all tasks known so far; known ones are repeated unchanged
  bool complete = false;             ///< nothing more will come
  std::vector<std::string> results;  ///< task ids whose artifacts assemble() reads
  std::vector<LeftOut> left_out;
  // What the package will take, as far as the plan is certain of it.
  bool plays_lights = false;
  bool plays_environment = false;
};

class Method {
 public:
  virtual ~Method() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual std::vector<OptionSpec> options() const = 0;
  /// Pure; called again whenever all tasks of the last plan are done, until it is complete.
  [[nodiscard]] virtual Plan plan(const PlanInputs& inputs) const = 0;
  /// Levels of effort by which an accuracy is reached; 0: this method knows none.
  [[nodiscard]] virtual int effort_levels() const { return 0; }
  /// `options` with those of a level, from 0 to effort_levels() − 1, the coarsest first.
  [[nodiscard]] virtual OptionValues with_effort(const OptionValues& options, int /*level*/) const {
    return options;
  }
  /// Kinds of task that run() knows.
  [[nodiscard]] virtual std::vector<std::string> kinds() const = 0;
  [[nodiscard]] virtual Artifact run(const TaskSpec& task, const TaskReader& reader) const = 0;
  /// Paper and section or equation that a kind of task implements; empty where it is nobody's.
  /// Goes into each artifact.
  [[nodiscard]] virtual std::string equation(const std::string& kind) const = 0;
  /// What the method's stages amount to in a bake of that size; `figures`: what a small bake of the
  /// scene found. Empty: bakes of this method are not predicted.
  [[nodiscard]] virtual std::vector<StageWork> work(const BakeSize& /*size*/,
                                                    const OptionValues& /*options*/,
                                                    const StageFigures& /*figures*/) const {
    return {};
  }
  /// Runtime data from finished artifacts: everything of the package but scene and error.
  /// `result(task id)` gives each artifact that Plan::results names.
  [[nodiscard]] virtual Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
      const OptionValues& options) const = 0;
};

/// The registry: one line per method.
const std::vector<const Method*>& all_methods();

}  // namespace prt
