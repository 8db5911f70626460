// Runs a method's tasks in this process, in order, with artifacts in memory: what tests of physics
// need.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "base/hash.h"
#include "methods/method.h"
#include "scene/embree/embree_ray_caster.h"

namespace prt::test {

/// Options of the shared table and the method's, at their defaults.
inline OptionValues default_options(const Method& method) {
  OptionValues options;
  for (const auto& spec : shared_options()) options.set(spec.key, spec.fallback);
  for (const auto& spec : method.options()) options.set(spec.key, spec.fallback);
  return options;
}

class InProcessBake : public PlanInputs {
 public:
  /// `isa` as make_embree_ray_caster takes it.
  InProcessBake(const Scene& scene, OptionValues options, const std::string& isa = "")
      : scene_(scene), caster_(make_embree_ray_caster(scene, isa)), options_(std::move(options)) {}

  /// Plans and runs until the plan is complete; returns it.
  Plan run(const Method& method) {
    for (;;) {
      Plan plan = method.plan(*this);
      std::size_t ran = 0;
      for (const TaskSpec& task : plan.tasks) {
        if (results_.contains(task.id)) continue;
        run_task(method, task);
        ++ran;
      }
      if (plan.complete) return plan;
      if (ran == 0) throw std::logic_error("a plan that is not complete and has no task to run");
    }
  }

  /// Runs one task whose inputs are done.
  void run_task(const Method& method, const TaskSpec& task) {
    run_task(task, [&](const TaskReader& reader) { return method.run(task, reader); });
  }
  /// The same for a task that is not the method's.
  void run_task(const TaskSpec& task, const std::function<Artifact(const TaskReader&)>& make) {
    const Reader reader(*this, task);
    const auto start = std::chrono::steady_clock::now();
    results_[task.id] = std::make_shared<Artifact>(make(reader));
    seconds[task.kind] +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  [[nodiscard]] const Scene& scene() const override { return scene_; }
  [[nodiscard]] const OptionValues& options() const override { return options_; }
  [[nodiscard]] std::shared_ptr<const Artifact> result(const std::string& id) const override {
    const auto it = results_.find(id);
    return it == results_.end() ? nullptr : it->second;
  }
  [[nodiscard]] const RayCaster& caster() const { return *caster_; }
  /// Forgets what later tasks should make anew.
  void forget(const std::string& id) { results_.erase(id); }

  std::map<std::string, double> seconds;  ///< by kind

 private:
  class Reader : public TaskReader {
   public:
    Reader(InProcessBake& bake, const TaskSpec& task) : bake_(bake), task_(task) {}
    [[nodiscard]] const Scene& scene() const override { return bake_.scene_; }
    [[nodiscard]] const RayCaster& ray_caster() const override { return *bake_.caster_; }
    [[nodiscard]] std::shared_ptr<const Artifact> input(std::size_t i) const override {
      return bake_.results_.at(task_.inputs.at(i));
    }
    [[nodiscard]] Digest input_content(std::size_t i) const override {
      return hash_text(task_.inputs.at(i));
    }
    [[nodiscard]] Memo& memo() const override { return bake_.memo_; }
    [[nodiscard]] bool stop_requested() const override { return false; }

   private:
    InProcessBake& bake_;
    const TaskSpec& task_;
  };

  const Scene& scene_;
  std::unique_ptr<RayCaster> caster_;
  OptionValues options_;
  std::map<std::string, std::shared_ptr<Artifact>> results_;
  Memo memo_;
};

}  // namespace prt::test
