#include "jobs/worker.h"

#include <algorithm>
#include <utility>

namespace prt {

Worker::Worker(WorkerId id, int slots, double heartbeat_seconds, double patience_seconds)
    : id_(id),
      slots_(std::max(1, slots)),
      heartbeat_seconds_(heartbeat_seconds),
      patience_seconds_(patience_seconds) {
  for (int slot = 0; slot < slots_; ++slot) idle_.insert(slot);
}

WorkerJoined Worker::join() const { return {id_, slots_}; }

std::vector<WorkerAction> Worker::handle(const WorkerEvent& event) {
  std::vector<WorkerAction> actions;
  std::visit([&](const auto& e) { on(e, actions); }, event);
  return actions;
}

bool Worker::has(const std::string& task) const {
  const auto is_it = [&](const Assignment& a) { return a.task.id == task; };
  return std::ranges::any_of(waiting_, is_it) ||
         std::ranges::any_of(running_, [&](const auto& r) { return is_it(r.second); });
}

void Worker::on(const Order& order, std::vector<WorkerAction>& actions) {
  heard_ = now_;
  if (std::holds_alternative<StillHere>(order)) return;
  if (const auto* dismissed = std::get_if<Dismissed>(&order)) {
    leaving_ = true;
    waiting_.clear();
    actions.emplace_back(Leave{dismissed->code});
    return;
  }
  const auto& assignment = std::get<Assignment>(order);
  if (leaving_ || has(assignment.task.id)) return;  // it is under way already
  waiting_.push_back(assignment);
  start_waiting(actions);
}

void Worker::start_waiting(std::vector<WorkerAction>& actions) {
  while (!waiting_.empty() && !idle_.empty()) {
    const int slot = *idle_.begin();
    idle_.erase(slot);
    actions.emplace_back(Start{slot, waiting_.front()});
    running_.emplace(slot, std::move(waiting_.front()));
    waiting_.pop_front();
  }
}

void Worker::on(const SlotFinished& finished, std::vector<WorkerAction>& actions) {
  const auto it = running_.find(finished.slot);
  if (it == running_.end()) return;
  const Assignment assignment = std::move(it->second);
  running_.erase(it);
  idle_.insert(finished.slot);
  const std::string& task = assignment.task.id;
  const Outcome& o = finished.outcome;
  switch (o.kind) {
    case Outcome::Kind::kDone:
      actions.emplace_back(
          Report{TaskDone{id_, task, assignment.key, o.content, o.adopted, o.cost, o.figures}});
      break;
    case Outcome::Kind::kFailed:
      actions.emplace_back(Report{TaskFailed{id_, task, o.message, o.user_error}});
      break;
    case Outcome::Kind::kInputUnsound:
      actions.emplace_back(Report{InputUnsound{id_, task, o.input}});
      break;
    case Outcome::Kind::kDropped:
      break;
  }
  start_waiting(actions);
}

void Worker::on(const Tick& tick, std::vector<WorkerAction>& actions) {
  if (now_ == 0.0) heard_ = tick.now;
  // As the coordinator does: silence until the tick before this one.
  const bool silent = patience_seconds_ > 0.0 && now_ - heard_ > patience_seconds_;
  now_ = tick.now;
  if (silent && !leaving_) {
    leaving_ = true;
    waiting_.clear();
    actions.emplace_back(Leave{ExitCode::kInterrupted});
    return;
  }
  if (heartbeat_seconds_ <= 0.0 || tick.now - told_ < heartbeat_seconds_) return;
  told_ = tick.now;
  actions.emplace_back(Report{Heartbeat{id_}});
}

}  // namespace prt
