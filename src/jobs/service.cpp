#include "jobs/service.h"

#include <chrono>
#include <deque>
#include <limits>
#include <utility>

#include "base/clock.h"

namespace prt {

namespace {

/// Latency of a message against the share of a core that polling costs (1 ms: 2.6 %).
constexpr std::chrono::microseconds kPollInterval{1000};
/// Alone there is nothing to poll but the stop flag, and for a worker without a free slot nothing
/// but being sent home: a task that ends wakes it all the same.
constexpr std::chrono::microseconds kCalmInterval{20000};
constexpr WorkerId kCoordinatorRank = 0;

bool stop_wanted(const ServiceSettings& settings) {
  return settings.stop != nullptr && settings.stop->load();
}

bool drain_wanted(const ServiceSettings& settings) {
  return settings.drain != nullptr && settings.drain->load();
}

/// Rank 0's loop: a coordinator, and a worker that it talks to without messages.
class CoordinatorLoop {
 public:
  CoordinatorLoop(Coordinator& coordinator, BakeHost& host, Link& link, Slots& slots)
      : coordinator_(coordinator),
        host_(host),
        link_(link),
        slots_(slots),
        worker_(kCoordinatorRank, slots.count()) {}

  LoopEnd run(const ServiceSettings& settings) {
    events_.emplace_back(worker_.join());
    events_.push_back(host_.plan_on(coordinator_));
    while (!end_) {
      const double now = steady_seconds();
      if (stop_wanted(settings) || now > drain_until_) return {ExitCode::kInterrupted, ""};
      if (drain_wanted(settings)) events_.emplace_back(DrainRequested{});
      // The time first, so that what came in while we were busy is heard now, and not long ago.
      events_.emplace_back(Tick{now});
      events_.emplace_back(Heartbeat{kCoordinatorRank});
      gather();
      tell_alive(now, settings.heartbeat_seconds);
      while (!events_.empty() && !end_) {
        const Event event = std::move(events_.front());
        events_.pop_front();
        if (const auto* stop = std::get_if<StopRequested>(&event)) return {stop->code, ""};
        if (std::holds_alternative<DrainRequested>(event)) {
          drain_until_ = std::min(drain_until_, now + settings.grace_seconds);
        }
        for (const Command& command : coordinator_.handle(event)) obey(command);
      }
      host_.tick(coordinator_, now);
      if (!end_) slots_.wait(link_.size() > 1 ? kPollInterval : kCalmInterval);
    }
    return *end_;
  }

 private:
  void tell_alive(double now, double every) {
    if (now - told_ < every) return;
    told_ = now;
    for (WorkerId rank = kCoordinatorRank + 1; rank < link_.size(); ++rank) {
      link_.send(rank, encode_order(StillHere{}));
    }
  }

  void gather() {
    for (const SlotFinished& finished : slots_.take_finished()) act(worker_.handle(finished));
    while (const auto message = link_.poll()) events_.push_back(decode_report(message->text));
  }

  void act(const std::vector<WorkerAction>& actions) {
    for (const WorkerAction& action : actions) {
      if (const auto* start = std::get_if<Start>(&action)) {
        slots_.start(start->slot, start->assignment);
      } else if (const auto* report = std::get_if<Report>(&action)) {
        events_.push_back(report->event);
      }
    }
  }

  void obey(const Command& command) {
    if (const auto* assign = std::get_if<Assign>(&command)) {
      if (assign->worker == kCoordinatorRank) {
        act(worker_.handle(Order{assign->assignment}));
      } else {
        link_.send(assign->worker, encode_order(assign->assignment));
      }
    } else if (const auto* record = std::get_if<Record>(&command)) {
      host_.record(*record);
    } else if (std::holds_alternative<StageDone>(command)) {
      events_.push_back(host_.plan_on(coordinator_));
    } else if (std::holds_alternative<AllDone>(command)) {
      if (const auto event = host_.finish(coordinator_)) {
        events_.push_back(*event);
      } else {
        end_ = LoopEnd{};
      }
    } else if (std::holds_alternative<Drained>(command)) {
      end_ = LoopEnd{ExitCode::kInterrupted, ""};
    } else if (const auto* fail = std::get_if<Fail>(&command)) {
      end_ = LoopEnd{fail->user_error ? ExitCode::kBadInput : ExitCode::kFailure, fail->message};
    }
  }

  Coordinator& coordinator_;
  BakeHost& host_;
  Link& link_;
  Slots& slots_;
  Worker worker_;
  std::deque<Event> events_;
  std::optional<LoopEnd> end_;
  double told_ = 0.0;
  double drain_until_ = std::numeric_limits<double>::infinity();
};

}  // namespace

LoopEnd run_coordinator(Coordinator& coordinator, BakeHost& host, Link& link, Slots& slots,
                        const ServiceSettings& settings) {
  return CoordinatorLoop(coordinator, host, link, slots).run(settings);
}

void dismiss_all(Link& link, ExitCode code) {
  // Not only those that have joined: a bake with nothing left to do ends before others have said
  // a word, and they would wait for ever.
  for (WorkerId rank = kCoordinatorRank + 1; rank < link.size(); ++rank) {
    link.send(rank, encode_order(Dismissed{code}));
  }
}

ExitCode run_worker(Link& link, Slots& slots, const ServiceSettings& settings) {
  Worker worker(link.rank(), slots.count(), settings.heartbeat_seconds, settings.patience_seconds);
  bool told_to_drain = false;
  std::optional<ExitCode> end;
  const auto act = [&](const std::vector<WorkerAction>& actions) {
    for (const WorkerAction& action : actions) {
      if (const auto* start = std::get_if<Start>(&action)) {
        slots.start(start->slot, start->assignment);
      } else if (const auto* report = std::get_if<Report>(&action)) {
        link.send(kCoordinatorRank, encode_report(report->event));
      } else {
        end = std::get<Leave>(action).code;
      }
    }
  };
  link.send(kCoordinatorRank, encode_report(worker.join()));
  while (!end) {
    if (stop_wanted(settings)) {
      link.send(kCoordinatorRank, encode_report(StopRequested{}));
      return ExitCode::kInterrupted;
    }
    if (drain_wanted(settings) && !std::exchange(told_to_drain, true)) {
      link.send(kCoordinatorRank, encode_report(DrainRequested{}));
    }
    act(worker.handle(Tick{steady_seconds()}));
    for (const SlotFinished& finished : slots.take_finished()) act(worker.handle(finished));
    while (const auto message = link.poll()) act(worker.handle(decode_order(message->text)));
    if (!end) slots.wait(worker.has_free_slot() ? kPollInterval : kCalmInterval);
  }
  return *end;
}

}  // namespace prt
