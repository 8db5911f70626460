#include "apps/bake/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
    std::string out =
        fmt::format("{:<20} {:>6} {:>6} {:>8}\n", "stage", "tasks", "there", "to make");
    for (const auto& [name, stage] : coordinator_.progress()) {
      out += fmt::format("{:<20} {:>6} {:>6} {:>8}\n", name, stage.total, stage.done,
                         stage.total - stage.done);
    }
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
      events_.emplace_back(TasksAdded{plan_.all.tasks, plan_.all.complete || plan_.undecided});
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

namespace {

std::string prediction_row(const StagePrediction& s) {
  constexpr double kMega = 1e6;
  return fmt::format("{:<20} {:>6.0f} {:>9} {:>9.2f} {:>9.2f} {:>9.1f}\n", s.stage, s.tasks,
                     s.rays > 0.0 ? fmt::format("{:.2f}", s.rays / kMega) : "-", s.seconds,
                     s.bytes / kMega, s.memory / kMega);
}

}  // namespace

std::string prediction_text(const BakePrediction& prediction, int threads, int ranks) {
  constexpr double kMega = 1e6;
  std::string out = fmt::format(
      "\nPredicted for about {:.0f} samples in {:.0f} clusters, from a small bake of this scene in "
      "memory ({:.1f} s):\n{:<20} {:>6} {:>9} {:>9} {:>9} {:>9}\n",
      prediction.samples, prediction.clusters, prediction.pilot_seconds, "stage", "tasks", "Mrays",
      "core s", "MB", "MB/task");
  for (const StagePrediction& stage : prediction.stages) out += prediction_row(stage);
  const StagePrediction total = prediction.total();
  out += prediction_row(total);
  const int all = std::max(1, threads * ranks);
  out += fmt::format("about {:.1f} s with {} threads in all, {:.0f} MB on disk, {:.0f} MB a rank\n",
                     total.seconds / all, all, total.bytes / kMega, threads * total.memory / kMega);
  out += "survey of the scene: " + prediction.survey.dump() + "\n";
  for (const LeftOut& l : prediction.left_out) {
    out += "expected to be left out: " + l.what + ": " + l.reason + "\n";
  }
  return out;
}

std::string levels_text(const std::vector<double>& seconds) {
  std::string out = "levels of effort, each by itself:";
  for (std::size_t level = 0; level < seconds.size(); ++level) {
    out += fmt::format("{} {}: {:.0f} s", level == 0 ? "" : ",", level, std::ceil(seconds[level]));
  }
  return out + "\n";
}

}  // namespace prt
