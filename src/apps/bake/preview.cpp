#include "apps/bake/preview.h"

#include <fmt/format.h>

#include <deque>

#include "base/log.h"
#include "jobs/coordinator.h"

namespace prt {

namespace {

/// Lets the coordinator plan with a worker that finds what is there and makes nothing.
class Preview {
 public:
  Preview(Planner& planner, const ArtifactStore& store, const SceneHashes& scene,
          const ManifestContents& manifest)
      : planner_(planner), store_(store), coordinator_({scene, 0.0, {}}, known_of(manifest)) {}

  void run() {
    constexpr int kPlenty = 1 << 30;
    events_.emplace_back(WorkerJoined{0, kPlenty});
    plan();
    while (!events_.empty()) {
      const Event event = std::move(events_.front());
      events_.pop_front();
      for (const Command& command : coordinator_.handle(event)) obey(command);
    }
  }

  [[nodiscard]] std::string text() const {
    std::string out = fmt::format("{:<20} {:>6} {:>6} {:>8} {:>12}\n", "stage", "tasks", "there",
                                  "to make", "predicted s");
    double predicted = 0.0;
    for (const auto& [name, stage] : coordinator_.progress()) {
      const double cost = stage.cost_total - stage.cost_done;
      predicted += cost;
      out += fmt::format("{:<20} {:>6} {:>6} {:>8} {:>12.1f}\n", name, stage.total, stage.done,
                         stage.total - stage.done, cost);
    }
    out += fmt::format("about {:.1f} s of work on one core\n", predicted);
    if (!plan_.all.complete) out += "later stages are planned from what these measure\n";
    for (const LeftOut& l : plan_.all.left_out)
      out += "left out: " + l.what + ": " + l.reason + "\n";
    return out;
  }

 private:
  static KnownContents known_of(const ManifestContents& manifest) {
    KnownContents known;
    for (const ManifestEntry& entry : manifest.entries) known[entry.key] = entry.content;
    return known;
  }

  void plan() {
    try {
      plan_ = planner_.plan([this](const std::string& task) { return coordinator_.result(task); });
      events_.emplace_back(TasksAdded{plan_.all.tasks, plan_.all.complete});
    } catch (const ResultDistrusted& e) {
      log::warn("{}; a bake makes it again", e.what());
    }
  }

  void obey(const Command& command) {
    if (const auto* assign = std::get_if<Assign>(&command)) {
      const Assignment& a = assign->assignment;
      if (a.expected && store_.bytes(a.task.kind, a.key) > 0) {
        events_.emplace_back(TaskDone{0, a.task.id, a.key, *a.expected, true, {}, {}});
      }
    } else if (std::holds_alternative<StageDone>(command)) {
      plan();
    }
  }

  Planner& planner_;
  const ArtifactStore& store_;
  Coordinator coordinator_;
  BakePlan plan_;
  std::deque<Event> events_;
};

}  // namespace

std::string preview_plan(Planner& planner, const ArtifactStore& store, const SceneHashes& scene,
                         const ManifestContents& manifest) {
  Preview preview(planner, store, scene, manifest);
  preview.run();
  return preview.text();
}

}  // namespace prt
