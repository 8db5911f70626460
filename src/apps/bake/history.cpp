#include "apps/bake/history.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prt {

nlohmann::json figures_of(const Artifact& artifact) {
  nlohmann::json figures = nlohmann::json::object();
  for (const auto& [name, value] : artifact.attributes.items()) {
    if (value.is_number()) figures[name] = value;
  }
  return figures;
}

History::History(const std::vector<ManifestEntry>& earlier) {
  for (const ManifestEntry& entry : earlier) earlier_[entry.key] = entry;
}

const TaskHistory& History::add(const Record& record) {
  const TaskDone& done = record.done;
  TaskHistory task{done.task,   record.stage,  done.key,  done.content,
                   done.worker, !done.adopted, done.cost, done.figures};
  const auto known = earlier_.find(done.key);
  if (done.adopted) {
    // What adopting took says nothing about the task.
    task.cost = TaskCost{};
    task.cost.bytes = done.cost.bytes;
  }
  if (done.adopted && known != earlier_.end()) {
    const ManifestEntry& entry = known->second;
    task.rank = entry.rank;
    task.cost.seconds = entry.seconds;
    task.cost.cpu_seconds = entry.cpu_seconds;
    task.cost.began = static_cast<double>(entry.finished) - entry.seconds;
    task.cost.bytes = entry.bytes;
  }
  made_ += task.made ? 1 : 0;
  return tasks_.emplace_back(std::move(task));
}

void History::fill_figures(const std::function<nlohmann::json(const std::string& task)>& figures) {
  for (TaskHistory& task : tasks_) {
    if (!task.made) task.figures = figures(task.task);
  }
}

double History::earlier_seconds() const {
  std::vector<std::pair<double, double>> spans;
  for (const TaskHistory& task : tasks_) {
    if (!task.made && task.cost.seconds > 0.0) {
      spans.emplace_back(task.cost.began, task.cost.began + task.cost.seconds);
    }
  }
  std::ranges::sort(spans);
  double total = 0.0;
  double reached = -1.0;
  for (const auto& [begin, end] : spans) {
    total += std::max(0.0, end - std::max(begin, reached));
    reached = std::max(reached, end);
  }
  return total;
}

ManifestEntry manifest_entry(const TaskHistory& task) {
  ManifestEntry entry;
  entry.task = task.task;
  entry.kind = task.stage;
  entry.key = task.key;
  entry.content = task.content;
  entry.seconds = task.cost.seconds;
  entry.cpu_seconds = task.cost.cpu_seconds;
  entry.bytes = task.cost.bytes;
  entry.rank = task.rank;
  entry.finished = std::llround(task.cost.began + task.cost.seconds);
  return entry;
}

std::string chrome_trace(const std::vector<TaskHistory>& tasks) {
  double first = 0.0;
  for (const TaskHistory& task : tasks) {
    if (task.made && (first == 0.0 || task.cost.began < first)) first = task.cost.began;
  }
  constexpr double kMicroseconds = 1e6;
  nlohmann::json events = nlohmann::json::array();
  for (const TaskHistory& task : tasks) {
    if (!task.made) continue;
    events.push_back({{"name", task.task},
                      {"cat", task.stage},
                      {"ph", "X"},
                      {"ts", (task.cost.began - first) * kMicroseconds},
                      {"dur", task.cost.seconds * kMicroseconds},
                      {"pid", task.rank},
                      {"tid", task.cost.slot},
                      {"args", {{"bytes", task.cost.bytes}, {"cpu_s", task.cost.cpu_seconds}}}});
  }
  return nlohmann::json{{"traceEvents", events}, {"displayTimeUnit", "ms"}}.dump() + "\n";
}

}  // namespace prt
