#include "scaling/simulation.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>
#include <map>
#include <queue>
#include <stdexcept>
#include <unordered_map>

#include "jobs/coordinator.h"
#include "jobs/messages.h"
#include "scaling/shared_disk.h"

namespace prt::scaling {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr WorkerId kCoordinatorRank = 0;

/// What store/manifest.cpp does for a line, but for handing it to the operating system.
std::string manifest_line(const Record& record) {
  const TaskDone& done = record.done;
  const std::string text = nlohmann::json{
      {"task", done.task},
      {"kind", record.stage},
      {"key", done.key.hex()},
      {"content", done.content.hex()},
      {"seconds", done.cost.seconds},
      {"cpu_seconds", done.cost.cpu_seconds},
      {"bytes", done.cost.bytes},
      {"rank", done.worker},
      {"finished",
       done.cost.began}}.dump();
  return hash_text(text).hex() + " " + text + "\n";
}

/// Artifacts a rank holds; the one used longest ago goes first.
class Cache {
 public:
  /// True if it was there; it is then, if it fits.
  bool use(std::size_t artifact, double bytes, double most) {
    const auto found = entries_.find(artifact);
    if (found != entries_.end()) {
      by_use_.splice(by_use_.end(), by_use_, found->second.place);
      return true;
    }
    if (bytes > most) return false;
    entries_[artifact] = {bytes, by_use_.insert(by_use_.end(), artifact)};
    bytes_ += bytes;
    while (bytes_ > most) {
      bytes_ -= entries_.at(by_use_.front()).bytes;
      entries_.erase(by_use_.front());
      by_use_.pop_front();
    }
    return false;
  }

 private:
  struct Entry {
    double bytes;
    std::list<std::size_t>::iterator place;
  };
  std::unordered_map<std::size_t, Entry> entries_;
  std::list<std::size_t> by_use_;
  double bytes_ = 0.0;
};

/// Whether a task of that kind looks for the samples that its rays hit.
bool needs_search(const std::string& kind) {
  return kind == "cells" || kind == "reference" || kind == "rays";
}

class Simulation {
 public:
  Simulation(const BakeGraph& graph, const Machine& machine)
      : graph_(graph),
        m_(machine),
        coordinator_({}, {}),
        disk_(machine.rank_bandwidth, machine.total_bandwidth),
        ranks_(static_cast<std::size_t>(machine.ranks)) {}

  Outcome run() {
    begin();
    while (!end_) {
      const double next = queue_.empty() ? kNever : queue_.top().time;
      if (disk_.next_end() <= next) {
        const double now = disk_.next_end();
        if (now == kNever) throw std::logic_error("the simulated bake stands still");
        transferred(disk_.finish_next(), now);
      } else {
        const Happening happening = queue_.top();
        queue_.pop();
        happen(happening);
      }
    }
    outcome_.seconds = *end_;
    return outcome_;
  }

 private:
  enum class What { kTurn, kOrder, kComputed };
  struct Happening {
    double time;
    std::uint64_t order;
    What what;
    WorkerId worker;
    bool operator>(const Happening& other) const {
      return time != other.time ? time > other.time : order > other.order;
    }
  };
  struct Rank {
    Assignment assignment;
    bool is_writing = false;
    bool is_set_up = false;
    double transfer_began = 0.0;
    Cache cache;
  };

  void begin() {
    const double up = m_.launch_seconds + m_.launch_per_rank * m_.ranks + m_.scene_seconds;
    measure_heartbeats();
    free_from_ = up;
    for (WorkerId rank = 0; rank < m_.ranks; ++rank) tell(rank, WorkerJoined{rank, 1}, up);
    free_from_ = plan(up);
  }

  /// Heartbeats are too many to simulate: they slow the coordinator down evenly.
  void measure_heartbeats() {
    if (!m_.charge_coordinator || m_.ranks == 1 || m_.heartbeat <= 0.0) return;
    constexpr int kTimes = 1000;
    Coordinator coordinator({}, {});
    const std::string text = encode_report(Heartbeat{0});
    const double seconds = timed([&] {
      for (int i = 0; i < kTimes; ++i) (void)coordinator.handle(decode_report(text));
    });
    const double share = seconds / kTimes * m_.ranks / m_.heartbeat;
    slower_ = 1.0 / std::max(0.1, 1.0 - share);
  }

  void schedule(double time, What what, WorkerId worker) {
    queue_.push({time, order_++, what, worker});
  }

  void happen(const Happening& happening) {
    switch (happening.what) {
      case What::kTurn:
        if (happening.time == next_turn_) turn(happening.time);
        return;
      case What::kOrder:
        return ordered(happening.worker, happening.time);
      case What::kComputed:
        return computed(happening.worker, happening.time);
    }
  }

  // ---- the coordinating rank's loop (service.cpp)
  // -------------------------------------------------

  /// A message to the coordinator. Its own rank's results wake it, others wait for its next look.
  void tell(WorkerId worker, Event event, double now) {
    const bool wakes = worker == kCoordinatorRank;
    const double arrival = wakes ? now : now + m_.latency;
    inbox_.emplace(arrival, std::move(event));
    double at = std::max(free_from_, arrival);
    if (!wakes && m_.poll > 0.0) {
      const double looks = std::max(1.0, std::ceil((arrival - free_from_) / m_.poll));
      at = free_from_ + looks * m_.poll;
    }
    turn_by(at);
  }
  void turn_by(double time) {
    if (time >= next_turn_) return;
    next_turn_ = time;
    schedule(time, What::kTurn, kCoordinatorRank);
  }

  void turn(double now) {
    next_turn_ = kNever;
    double at = std::max(now, free_from_);
    const double heard = at;
    while (!end_ && !inbox_.empty() && inbox_.begin()->first <= heard) {
      const Event event = std::move(inbox_.begin()->second);
      inbox_.erase(inbox_.begin());
      at = receive(event, at);
    }
    free_from_ = at;
    if (!inbox_.empty()) turn_by(std::max(at, inbox_.begin()->first) + m_.poll);
  }

  /// Time goes on by what the coordinator really took.
  double spend(double at, double seconds) {
    if (!m_.charge_coordinator) return at;
    outcome_.coordinator += seconds;
    return at + slower_ * seconds;
  }

  double receive(const Event& event, double at) {
    if (const auto* done = std::get_if<TaskDone>(&event)) {
      ++outcome_.completions;
      if (done->worker != kCoordinatorRank) {
        const std::string text = encode_report(event);
        at = spend(at, timed([&] { (void)decode_report(text); }));
      }
    }
    return feed(event, at);
  }

  double feed(const Event& event, double at) {
    std::vector<Command> commands;
    at = spend(at, timed([&] { commands = coordinator_.handle(event); }));
    for (const Command& command : commands) at = obey(command, at);
    return at;
  }

  double obey(const Command& command, double at) {
    if (const auto* assign = std::get_if<Assign>(&command)) return send(*assign, at);
    if (const auto* record = std::get_if<Record>(&command)) {
      return spend(at, timed([&] { (void)manifest_line(*record); }));
    }
    if (std::holds_alternative<StageDone>(command)) return plan(at);
    if (std::holds_alternative<AllDone>(command)) {
      end_ = at + m_.assembly.at(graph_.package_bytes);
    } else if (const auto* fail = std::get_if<Fail>(&command)) {
      throw std::logic_error(fail->message);
    }
    return at;
  }

  double send(const Assign& assign, double at) {
    ranks_[static_cast<std::size_t>(assign.worker)].assignment = assign.assignment;
    if (assign.worker == kCoordinatorRank) {
      schedule(at, What::kOrder, assign.worker);
      return at;
    }
    at = spend(at, timed([&] { (void)encode_order(assign.assignment); }));
    // A worker looks for messages that often; on average half of that goes by.
    schedule(at + m_.latency + 0.5 * m_.poll, What::kOrder, assign.worker);
    return at;
  }

  /// The planner makes all tasks anew every time; here they are copied. It reads a few artifacts.
  double plan(double at) {
    const std::size_t known = planned_ == 0 ? 0 : graph_.plans[planned_ - 1];
    const std::size_t count = graph_.plans.at(planned_++);
    TasksAdded added;
    const double making = timed([&] {
      added.tasks.assign(graph_.tasks.begin(), graph_.tasks.begin() + static_cast<long>(count));
    });
    added.last = planned_ == graph_.plans.size();
    if (known > 0) at += m_.open_seconds * planner_reads(known);
    const double before = at;
    at = feed(added, spend(at, making));
    outcome_.planning += at - before;
    return at;
  }
  /// Residuals of all clusters decide whether another round follows.
  [[nodiscard]] double planner_reads(std::size_t known) const {
    double reads = 1.0;
    for (std::size_t i = 0; i < known; ++i) reads += graph_.tasks[i].kind == "residual" ? 1.0 : 0.0;
    return reads;
  }

  // ---- the workers
  // ----------------------------------------------------------------------------------

  void ordered(WorkerId worker, double now) {
    Rank& rank = ranks_[static_cast<std::size_t>(worker)];
    const std::size_t task = graph_.index.at(rank.assignment.task.id);
    double bytes = 0.0;
    double files = 0.0;
    Load search;  // that its inputs ask for
    for (const std::size_t input : graph_.inputs[task]) {
      const Load& made = graph_.loads[input];
      if (made.is_kept) continue;
      if (made.use_seconds > 0.0) {
        search.use_seconds += made.use_seconds;
        search.bytes += made.bytes;
      }
      if (rank.cache.use(input, made.bytes, m_.cache_bytes)) continue;
      bytes += made.bytes;
      files += 1.0;
    }
    const double using_them = search_seconds(rank, task, search);
    outcome_.read_bytes += bytes;
    overhead_[worker] = files * m_.open_seconds + bytes * m_.decode_per_byte + using_them;
    if (!rank.is_set_up) overhead_[worker] += m_.first_task_seconds;
    rank.is_set_up = true;
    rank.is_writing = false;
    transfer(worker, bytes, now);
  }

  /// What the neighbour search takes unless the rank has it: it is kept as long as an artifact of
  /// its size would be.
  double search_seconds(Rank& rank, std::size_t task, const Load& search) {
    if (search.use_seconds <= 0.0 || !needs_search(graph_.tasks[task].kind)) return 0.0;
    const Load& load = graph_.loads[task];
    const std::size_t name = graph_.tasks.size() + load.search_part;
    const bool is_there = rank.cache.use(name, load.search_share * search.bytes, m_.cache_bytes);
    return is_there ? 0.0 : load.search_share * search.use_seconds;
  }

  void transfer(WorkerId worker, double bytes, double now) {
    ranks_[static_cast<std::size_t>(worker)].transfer_began = now;
    if (bytes > 0.0 && m_.rank_bandwidth < kNever) {
      disk_.start(worker, bytes, now);
    } else {
      transferred(worker, now);
    }
  }

  void transferred(WorkerId worker, double now) {
    const Rank& rank = ranks_[static_cast<std::size_t>(worker)];
    outcome_.disk += now - rank.transfer_began;
    if (rank.is_writing) return report(worker, now);
    const Load& load = graph_.loads[graph_.index.at(rank.assignment.task.id)];
    const double seconds = load.seconds + overhead_[worker] + m_.commit_seconds;
    outcome_.busy += seconds;
    schedule(now + seconds, What::kComputed, worker);
  }

  void computed(WorkerId worker, double now) {
    Rank& rank = ranks_[static_cast<std::size_t>(worker)];
    const Load& load = graph_.loads[graph_.index.at(rank.assignment.task.id)];
    rank.is_writing = true;
    transfer(worker, load.bytes, now);
  }

  void report(WorkerId worker, double now) {
    const Assignment& done = ranks_[static_cast<std::size_t>(worker)].assignment;
    const Digest content = hash_text(done.key.hex());
    TaskDone event{worker, done.task.id, done.key, content, false, {}, {}};
    // As many figures as a real report has on average.
    event.figures = {{"rank", 50}, {"error", 0.0123}, {"energy", 0.987}, {"samples", 1000}};
    tell(worker, std::move(event), now);
  }

  const BakeGraph& graph_;
  Machine m_;
  Coordinator coordinator_;
  SharedDisk disk_;
  std::vector<Rank> ranks_;
  std::map<WorkerId, double> overhead_;
  std::priority_queue<Happening, std::vector<Happening>, std::greater<>> queue_;
  std::uint64_t order_ = 0;
  std::multimap<double, Event> inbox_;
  double free_from_ = 0.0;  ///< the coordinator is busy until then
  double next_turn_ = kNever;
  double slower_ = 1.0;
  std::size_t planned_ = 0;
  std::optional<double> end_;
  Outcome outcome_;
};

}  // namespace

double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double clock_cost() {
  static const double kCost = [] {
    constexpr int kTimes = 20'000;
    const double began = thread_seconds();
    for (int i = 0; i < kTimes; ++i) (void)thread_seconds();
    return (thread_seconds() - began) / kTimes;
  }();
  return kCost;
}

Machine ideal_machine(int ranks) {
  Machine machine;
  machine.ranks = ranks;
  machine.latency = machine.poll = machine.open_seconds = machine.commit_seconds = 0.0;
  machine.launch_seconds = machine.launch_per_rank = machine.scene_seconds = 0.0;
  machine.first_task_seconds = machine.decode_per_byte = machine.heartbeat = 0.0;
  machine.rank_bandwidth = machine.total_bandwidth = kNever;
  machine.charge_coordinator = false;
  return machine;
}

Outcome simulate(const BakeGraph& graph, const Machine& machine) {
  return Simulation(graph, machine).run();
}

}  // namespace prt::scaling
