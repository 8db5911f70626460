#include "apps/bake/bake_host.h"

#include <algorithm>
#include <stdexcept>

#include "base/log.h"

namespace prt {

Host::Host(Planner& planner, History& history, FileSystem& fs, BakeFolder& folder,
           WriteResults write_results, bool keep_all, int verbosity)
    : planner_(planner),
      folder_(folder),
      write_results_(std::move(write_results)),
      keep_all_(keep_all),
      progress_(verbosity),
      status_(fs, folder.path()),
      history_(history) {}

void Host::record(const Record& record) {
  done_[record.done.task] = history_.tasks().size();
  const TaskHistory& task = history_.add(record);
  if (!record.known) folder_.manifest().append(manifest_entry(task), now_);
  if (keep_all_ || !plan_.all.complete) return;
  for (const std::string& input : specs_.at(record.done.task).inputs) {
    if (--unfinished_readers_[input] == 0) let_go(input);
  }
}

Event Host::plan_on(const Coordinator& coordinator) {
  const auto find = [&](const std::string& task) { return coordinator.result(task); };
  try {
    plan_ = planner_.plan(find);
  } catch (const ResultDistrusted& e) {
    log::warn("{}; it will be made again", e.what());
    return ResultUnsound{e.task};
  }
  if (!plan_.all.complete && plan_.all.tasks.size() <= planned_) {
    throw std::logic_error(
        "the planner has no next step and is not complete; please report this bug");
  }
  planned_ = plan_.all.tasks.size();
  for (const TaskSpec& task : plan_.all.tasks) specs_.emplace(task.id, task);
  if (plan_.all.complete && !keep_all_) count_readers();
  return TasksAdded{plan_.all.tasks, plan_.all.complete};
}

/// From here on it is known who reads what.
void Host::count_readers() {
  unfinished_readers_.clear();
  for (const auto& [id, task] : specs_) {
    for (const std::string& input : task.inputs) {
      unfinished_readers_[input] += done_.contains(id) ? 0 : 1;
    }
  }
  let_go_all();
}

void Host::let_go_all() {
  for (const auto& [task, readers] : unfinished_readers_) {
    if (readers == 0) let_go(task);
  }
}

void Host::let_go(const std::string& task) {
  const auto contains = [&](const std::vector<std::string>& ids) {
    return std::ranges::find(ids, task) != ids.end();
  };
  if (planner_.read_tasks().contains(task) || contains(plan_.all.results) ||
      contains(plan_.evaluation_results)) {
    return;
  }
  const TaskHistory& history = history_.tasks()[done_.at(task)];
  if (folder_.store().bytes(history.stage, history.key) == 0) return;
  // Its line must be on the disk first: it tells a resume that this one was let go on purpose.
  folder_.manifest().sync();
  folder_.store().remove(history.stage, history.key);
}

std::optional<Event> Host::finish(const Coordinator& coordinator) {
  if (!keep_all_) let_go_all();  // what was made a second time for a late reader
  try {
    write_results_(*this, [&](const std::string& task) { return coordinator.result(task); });
  } catch (const ResultDistrusted& e) {
    log::warn("{}; it will be made again", e.what());
    return ResultUnsound{e.task};
  }
  if (any_was_lost_) sweep();
  status_.finish(coordinator);
  return std::nullopt;
}

/// Removes what lost ranks were writing. All is done: who still writes, writes it a second time.
void Host::sweep() {
  try {
    folder_.store().remove_temporaries();
  } catch (const FileError& e) {
    log::warn("{}; the next start removes what lost ranks left", e.what());
  }
}

void Host::tick(const Coordinator& coordinator, double now) {
  now_ = now;
  folder_.manifest().sync_if_due(now);
  const int lost = coordinator.ranks().lost;
  if (lost > lost_) {
    log::warn("{} rank(s) are silent; others take over their tasks", lost);
    any_was_lost_ = true;
  }
  lost_ = lost;
  progress_.tick(coordinator, now);
  status_.tick(coordinator, now);
}

}  // namespace prt
