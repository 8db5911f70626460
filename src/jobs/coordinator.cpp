#include "jobs/coordinator.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace prt {

namespace {

constexpr std::size_t kUnknown = static_cast<std::size_t>(-1);
/// A file that turns bad again and again is a broken disk, not bad luck.
constexpr int kMostDistrust = 3;

}  // namespace

bool Coordinator::ReadyOrder::operator()(std::size_t a, std::size_t b) const {
  const Task& x = (*tasks)[a];
  const Task& y = (*tasks)[b];
  return x.chain != y.chain ? x.chain > y.chain : x.spec.id < y.spec.id;
}

Coordinator::Coordinator(Settings settings, KnownContents known)
    : settings_(std::move(settings)),
      contents_(std::move(known)),
      ready_(ReadyOrder{&tasks_}),
      unplaced_(ReadyOrder{&tasks_}),
      places_(1),
      place_index_{{"", 0}} {}

std::vector<Command> Coordinator::handle(const Event& event) {
  std::visit([this](const auto& e) { on(e); }, event);
  hand_out();
  announce();
  return std::exchange(commands_, {});
}

// ---- workers -----------------------------------------------------------------------------------

void Coordinator::on(const WorkerJoined& event) {
  WorkerState& worker = workers_.try_emplace(event.worker, ReadyOrder{&tasks_}).first->second;
  lose(worker);
  withdraw(event.worker, worker);
  give_up_places(worker);
  worker.slots = std::max(1, event.slots);
  worker.present = true;
  worker.heard = now_;
  offer(event.worker, worker);
  if (stopped_) commands_.emplace_back(Dismiss{event.worker, ExitCode::kInterrupted});
}

void Coordinator::hear(WorkerId id) {
  const auto it = workers_.find(id);
  if (it == workers_.end()) return;
  it->second.heard = now_;
  if (!it->second.present) {
    it->second.present = true;
    offer(id, it->second);
  }
}

void Coordinator::on(const Heartbeat& event) { hear(event.worker); }

void Coordinator::on(const WorkerLost& event) {
  const auto it = workers_.find(event.worker);
  if (it == workers_.end() || !it->second.present) return;
  lose(it->second);
  withdraw(event.worker, it->second);
  give_up_places(it->second);
  it->second.present = false;
}

void Coordinator::on(const Tick& event) {
  if (!clock_started_) {  // whoever spoke before there was a time speaks now
    for (auto& [id, worker] : workers_) worker.heard = event.now;
  }
  clock_started_ = true;
  // Silence is judged at the tick before this one: what was said by then has been heard since, even
  // if we were busy for longer than a lease.
  std::vector<WorkerId> silent;
  for (const auto& [id, worker] : workers_) {
    const bool leased = settings_.lease_seconds > 0.0 && worker.present;
    if (leased && now_ - worker.heard > settings_.lease_seconds) silent.push_back(id);
  }
  now_ = std::max(now_, event.now);
  for (const WorkerId id : silent) on(WorkerLost{id});
}

void Coordinator::lose(WorkerState& worker) {
  for (const std::size_t task : std::set<std::size_t>(worker.tasks)) release(task);
}

void Coordinator::offer(WorkerId id, WorkerState& worker) {
  const int free = worker.slots - static_cast<int>(worker.tasks.size());
  if (!worker.present || free <= 0) return;
  free_.emplace(-free, id);
  if (!worker.ready.empty()) served_.insert(id);
}

void Coordinator::withdraw(WorkerId id, WorkerState& worker) {
  free_.erase({static_cast<int>(worker.tasks.size()) - worker.slots, id});
  served_.erase(id);
}

/// What it held in memory is lost: its places are anybody's.
void Coordinator::give_up_places(WorkerState& worker) {
  for (const std::size_t place : std::exchange(worker.places, {})) places_[place].holder = -1;
  unplaced_.merge(worker.ready);
}

// ---- tasks -------------------------------------------------------------------------------------

std::size_t Coordinator::find(const std::string& id) const {
  const auto it = index_.find(id);
  return it == index_.end() ? kUnknown : it->second;
}

void Coordinator::on(const TasksAdded& event) {
  const std::size_t first_new = tasks_.size();
  for (const TaskSpec& spec : event.tasks) {
    if (!add_task(spec)) return;
  }
  for (std::size_t i = first_new; i < tasks_.size(); ++i) {
    if (!link_inputs(i)) return;
  }
  const std::vector<std::size_t> order = in_order(first_new);
  if (order.size() != tasks_.size() - first_new) {
    fail("the plan has a cycle of tasks that wait for each other; please report this bug");
    return;
  }
  measure_chains(order);
  for (std::size_t i = first_new; i < tasks_.size(); ++i) release(i);
  last_plan_ = event.last;
  announced_ = false;
}

bool Coordinator::add_task(const TaskSpec& spec) {
  if (const std::size_t known = find(spec.id); known != kUnknown) {
    const TaskSpec& old = tasks_[known].spec;
    const bool same = old.kind == spec.kind && old.version == spec.version &&
                      old.parameters == spec.parameters && old.inputs == spec.inputs &&
                      old.scene_parts == spec.scene_parts;
    if (!same) fail("task " + spec.id + " was planned twice, differently; please report this bug");
    return same;
  }
  index_[spec.id] = tasks_.size();
  Task& task = tasks_.emplace_back();
  task.spec = spec;
  task.place = place_index_.try_emplace(spec.place, places_.size()).first->second;
  if (task.place == places_.size()) places_.emplace_back();
  if (task.place > 0) places_[task.place].tasks.push_back(tasks_.size() - 1);
  ++undone_;
  if (!stage_progress_.contains(spec.kind)) stages_.push_back(spec.kind);
  StageProgress& stage = stage_progress_[spec.kind];
  ++stage.total;
  stage.cost_total += spec.cost;
  return true;
}

bool Coordinator::link_inputs(std::size_t index) {
  for (const std::string& id : tasks_[index].spec.inputs) {
    const std::size_t input = find(id);
    if (input == kUnknown) {
      fail("task " + tasks_[index].spec.id + " reads " + id +
           ", which nobody makes; please report this bug");
      return false;
    }
    tasks_[index].inputs.push_back(input);
    tasks_[input].dependents.push_back(index);
    if (tasks_[input].state != State::kDone) ++tasks_[index].missing;
  }
  return true;
}

/// The new tasks, each after its inputs; those of a cycle are missing.
std::vector<std::size_t> Coordinator::in_order(std::size_t first_new) const {
  // Old tasks never depend on new ones, so only the new ones can close a cycle.
  std::vector<std::size_t> waits(tasks_.size() - first_new, 0);
  std::vector<std::size_t> open;
  for (std::size_t i = first_new; i < tasks_.size(); ++i) {
    for (const std::size_t input : tasks_[i].inputs) waits[i - first_new] += input >= first_new;
    if (waits[i - first_new] == 0) open.push_back(i);
  }
  std::vector<std::size_t> order;
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    order.push_back(i);
    for (const std::size_t dependent : tasks_[i].dependents) {
      if (--waits[dependent - first_new] == 0) open.push_back(dependent);
    }
  }
  return order;
}

/// Of new tasks alone: older ones keep their rank, or lists that are sorted by it would break.
void Coordinator::measure_chains(const std::vector<std::size_t>& order) {
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    Task& task = tasks_[*it];
    double after = 0.0;
    for (const std::size_t dependent : task.dependents) {
      after = std::max(after, tasks_[dependent].chain);
    }
    task.chain = task.spec.cost + after;
  }
}

/// Takes a task from whoever has it; it runs (again) once its inputs are there.
void Coordinator::release(std::size_t index) {
  detach(index);
  Task& task = tasks_[index];
  remove_ready(index);
  task.state = State::kWaiting;
  if (task.missing == 0) make_ready(index);
}

void Coordinator::detach(std::size_t index) {
  Task& task = tasks_[index];
  if (task.state != State::kAssigned) return;
  WorkerState& worker = workers_.at(task.worker);
  withdraw(task.worker, worker);
  worker.tasks.erase(index);
  offer(task.worker, worker);
  task.worker = -1;
}

Digest Coordinator::key_of(const Task& task) const {
  std::vector<Digest> contents;
  for (const std::size_t input : task.inputs) contents.push_back(tasks_[input].content);
  return task_key(task.spec, contents, settings_.scene);
}

void Coordinator::make_ready(std::size_t index) {
  Task& task = tasks_[index];
  task.key = key_of(task);
  task.state = State::kReady;
  add_ready(index);
}

void Coordinator::take_place(std::size_t index, WorkerId id, WorkerState& worker) {
  Place& place = places_[index];
  if (index == 0 || place.holder >= 0) return;
  place.holder = id;
  worker.places.push_back(index);
  for (const std::size_t task : place.tasks) {
    if (unplaced_.erase(task) > 0) worker.ready.insert(task);
  }
}

/// Where a ready task is listed beside ready_: with the holder of its place, or with nobody's.
Coordinator::ReadyTasks& Coordinator::list_of(std::size_t index) {
  const WorkerId holder = places_[tasks_[index].place].holder;
  return holder < 0 ? unplaced_ : workers_.at(holder).ready;
}

void Coordinator::add_ready(std::size_t index) {
  ready_.insert(index);
  list_of(index).insert(index);
  const WorkerId holder = places_[tasks_[index].place].holder;
  if (holder >= 0) offer(holder, workers_.at(holder));
}

void Coordinator::remove_ready(std::size_t index) {
  if (ready_.erase(index) == 0) return;
  ReadyTasks& list = list_of(index);
  list.erase(index);
  if (list.empty()) served_.erase(places_[tasks_[index].place].holder);
}

void Coordinator::on(const TaskDone& event) {
  hear(event.worker);
  const std::size_t index = find(event.task);
  if (index == kUnknown || tasks_[index].key != event.key) return;  // not of this plan
  const auto [known, is_new] = contents_.try_emplace(event.key, event.content);
  if (known->second != event.content) {
    fail("task " + event.task + " gave another result than before (artifact " + event.key.hex() +
         ": content " + event.content.hex() + ", before " + known->second.hex() +
         "): a determinism bug, please report it; --fresh bakes anew");
    return;
  }
  if (tasks_[index].state == State::kDone) return;
  Task& task = tasks_[index];
  if (!task.recorded) commands_.emplace_back(Record{event, task.spec.kind, !is_new});
  finish(index, event);
}

void Coordinator::finish(std::size_t index, const TaskDone& event) {
  detach(index);
  remove_ready(index);
  Task& task = tasks_[index];
  task.state = State::kDone;
  task.content = event.content;
  StageProgress& stage = stage_progress_[task.spec.kind];
  ++stage.done;
  stage.cost_done += task.spec.cost;
  if (!task.recorded) {
    task.adopted = event.adopted;
    stage.adopted += event.adopted ? 1 : 0;
    stage.cost_adopted += event.adopted ? task.spec.cost : 0.0;
  }
  task.recorded = true;
  --undone_;
  for (const std::size_t dependent : task.dependents) {
    Task& next = tasks_[dependent];
    if (--next.missing == 0 && next.state == State::kWaiting) make_ready(dependent);
  }
}

/// A finished task's artifact is gone or bad: it runs again, and what waits for it waits.
void Coordinator::undo(std::size_t index) {
  Task& task = tasks_[index];
  StageProgress& stage = stage_progress_[task.spec.kind];
  settings_.spared.erase(*task.key);
  --stage.done;
  stage.cost_done -= task.spec.cost;
  ++undone_;
  announced_ = false;
  for (const std::size_t dependent : task.dependents) {
    Task& next = tasks_[dependent];
    ++next.missing;
    if (next.state == State::kReady) release(dependent);
  }
  release(index);
}

void Coordinator::on(const TaskFailed& event) {
  hear(event.worker);
  const std::size_t index = find(event.task);
  if (index == kUnknown || tasks_[index].state == State::kDone) return;
  release(index);
  fail(event.user_error ? event.message : "task " + event.task + ": " + event.message,
       event.user_error);
}

void Coordinator::on(const InputUnsound& event) {
  hear(event.worker);
  const std::size_t index = find(event.task);
  const std::size_t input = find(event.input);
  if (index == kUnknown || input == kUnknown) return;
  const Task& task = tasks_[index];
  if (task.state == State::kAssigned && task.worker == event.worker) release(index);
  if (task.state == State::kDone || tasks_[input].state != State::kDone) return;
  distrust(index, input);
}

void Coordinator::on(const ResultUnsound& event) {
  const std::size_t index = find(event.task);
  if (index == kUnknown || tasks_[index].state != State::kDone) return;
  distrust(index, index);
}

void Coordinator::distrust(std::size_t reader, std::size_t index) {
  if (++distrust_[{reader, index}] > kMostDistrust) {
    fail("the artifact of " + tasks_[index].spec.id + " was made again " +
         std::to_string(kMostDistrust) +
         " times and still cannot be read; check the disk of the output folder");
    return;
  }
  undo(index);
}

// ---- decisions ---------------------------------------------------------------------------------

/// Of the tasks whose place a free worker holds and of those of nobody's place the longest; a task
/// of somebody else's place only rather than nothing.
const Coordinator::ReadyTasks& Coordinator::best_for(WorkerId id) const {
  const ReadyTasks& own = workers_.at(id).ready;
  if (own.empty()) return unplaced_.empty() ? ready_ : unplaced_;
  if (unplaced_.empty()) return own;
  return ready_.key_comp()(*own.begin(), *unplaced_.begin()) ? own : unplaced_;
}

void Coordinator::hand_out() {
  while (!stopped_ && !draining_ && !ready_.empty()) {
    if (spare(*ready_.begin())) continue;
    if (free_.empty()) return;
    const WorkerId worker = served_.empty() ? free_.begin()->second : *served_.begin();
    const std::size_t task = *best_for(worker).begin();
    if (!spare(task)) assign(task, worker);
  }
}

bool Coordinator::spare(std::size_t index) {
  if (settings_.spared.empty()) return false;
  const Task& task = tasks_[index];
  const auto known = contents_.find(*task.key);
  if (known == contents_.end() || !settings_.spared.contains(*task.key)) return false;
  on(TaskDone{-1, task.spec.id, *task.key, known->second, true, {}, {}});
  return true;
}

void Coordinator::assign(std::size_t index, WorkerId id) {
  WorkerState& worker = workers_.at(id);
  Task& task = tasks_[index];
  remove_ready(index);
  withdraw(id, worker);
  worker.tasks.insert(index);
  take_place(task.place, id, worker);
  offer(id, worker);
  task.state = State::kAssigned;
  task.worker = id;

  Assignment assignment{task.spec, *task.key, std::nullopt, {}};
  if (const auto known = contents_.find(*task.key); known != contents_.end()) {
    assignment.expected = known->second;
  }
  for (const std::size_t input : task.inputs) {
    const Task& made = tasks_[input];
    assignment.inputs.push_back({made.spec.id, made.spec.kind, *made.key, made.content});
  }
  commands_.emplace_back(Assign{id, std::move(assignment)});
}

void Coordinator::announce() {
  if (stopped_) return;
  if (draining_) {
    if (ranks().busy > 0) return;
    stopped_ = true;
    commands_.emplace_back(Drained{});
    return;
  }
  if (announced_ || undone_ > 0) return;
  announced_ = true;
  if (last_plan_) {
    commands_.emplace_back(AllDone{});
  } else {
    commands_.emplace_back(StageDone{});
  }
}

void Coordinator::fail(std::string message, bool user_error) {
  if (stopped_) return;
  stopped_ = true;
  failed_ = true;
  commands_.emplace_back(Fail{std::move(message), user_error});
}

void Coordinator::on(const StopRequested& event) {
  stopped_ = true;
  for (const auto& [id, worker] : workers_) commands_.emplace_back(Dismiss{id, event.code});
}

void Coordinator::on(const DrainRequested&) { draining_ = true; }

// ---- questions ---------------------------------------------------------------------------------

std::vector<std::pair<std::string, StageProgress>> Coordinator::progress() const {
  std::vector<std::pair<std::string, StageProgress>> all;
  for (const std::string& stage : stages_) all.emplace_back(stage, stage_progress_.at(stage));
  return all;
}

RankCounts Coordinator::ranks() const {
  RankCounts counts;
  for (const auto& [id, worker] : workers_) {
    ++(!worker.present ? counts.lost : worker.tasks.empty() ? counts.idle : counts.busy);
  }
  return counts;
}

std::vector<WorkerId> Coordinator::lost() const {
  std::vector<WorkerId> all;
  for (const auto& [id, worker] : workers_) {
    if (!worker.present) all.push_back(id);
  }
  return all;
}

std::optional<TaskInput> Coordinator::result(const std::string& id) const {
  const std::size_t index = find(id);
  if (index == kUnknown || tasks_[index].state != State::kDone) return std::nullopt;
  const Task& task = tasks_[index];
  return TaskInput{id, task.spec.kind, *task.key, task.content};
}

}  // namespace prt
