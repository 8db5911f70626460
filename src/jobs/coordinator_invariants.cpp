// What must hold between any two events.
#include <stdexcept>

#include "jobs/coordinator.h"

namespace prt {

namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error("coordinator: " + what);
}

}  // namespace

void Coordinator::check_invariants() const {
  if (failed_) return;
  std::size_t undone = 0;
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    undone += tasks_[i].state != State::kDone;
    check_task(i);
  }
  require(undone == undone_, "count of undone tasks");
  check_workers();
  require(stopped_ || draining_ || ready_.empty() || free_.empty(),
          "a ready task waits beside a free worker");
}

void Coordinator::check_task(std::size_t index) const {
  const Task& task = tasks_[index];
  std::size_t missing = 0;
  for (const std::size_t input : task.inputs) missing += tasks_[input].state != State::kDone;
  const std::string& id = task.spec.id;
  require(missing == task.missing, id + ": count of missing inputs");
  require(ready_.contains(index) == (task.state == State::kReady), id + ": ready list");
  require(task.state != State::kReady || missing == 0, id + ": ready without its inputs");
  require(task.state != State::kWaiting || missing > 0, id + ": waits for nothing");
  const WorkerId holder = places_[task.place].holder;
  require(unplaced_.contains(index) == (task.state == State::kReady && holder < 0),
          id + ": list of tasks in nobody's place");
  require(holder < 0 || workers_.at(holder).ready.contains(index) == (task.state == State::kReady),
          id + ": list of its place's holder");
  require((task.worker >= 0) == (task.state == State::kAssigned), id + ": worker");
  require(task.state == State::kWaiting || task.key.has_value(), id + ": no key");
  if (task.state == State::kDone && missing == 0) {
    require(*task.key == key_of(task), id + ": key differs from its inputs'");
    require(contents_.at(*task.key) == task.content, id + ": content differs from what is known");
  }
}

void Coordinator::check_workers() const {
  std::size_t held = 0;
  std::size_t listed = unplaced_.size();
  std::size_t offered = 0;
  for (const auto& [id, worker] : workers_) {
    const int free = worker.slots - static_cast<int>(worker.tasks.size());
    require(free >= 0, "a worker holds more tasks than it has slots");
    require(worker.present || worker.tasks.empty(), "a lost worker holds a task");
    require(worker.present || worker.places.empty(), "a lost worker holds a place");
    listed += worker.ready.size();
    for (const std::size_t place : worker.places) {
      require(places_[place].holder == id, "worker and place disagree on who holds it");
    }
    require(served_.contains(id) == (worker.present && free > 0 && !worker.ready.empty()),
            "list of free workers whose places have ready tasks");
    if (worker.present && free > 0) {
      ++offered;
      require(free_.contains({-free, id}), "a free worker is not offered");
    }
    for (const std::size_t task : worker.tasks) {
      require(tasks_[task].worker == id, "worker and task disagree on who has it");
      ++held;
    }
  }
  require(listed == ready_.size(), "a task that is not ready is listed");
  require(offered == free_.size(), "a worker is offered that is not free");
  std::size_t assigned = 0;
  for (const Task& task : tasks_) assigned += task.state == State::kAssigned;
  require(held == assigned, "an assigned task is held by nobody");
}

}  // namespace prt
