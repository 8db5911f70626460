#include "jobs/slots.h"

#include <algorithm>
#include <new>
#include <utility>

#include "base/clock.h"

namespace prt {

namespace {

double wall_seconds() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

Outcome failed(std::string message, bool user_error) {
  Outcome outcome;
  outcome.kind = Outcome::Kind::kFailed;
  outcome.message = std::move(message);
  outcome.user_error = user_error;
  return outcome;
}

Outcome run_caught(TaskRunner& runner, const Assignment& assignment,
                   const std::atomic<bool>& stop) {
  Outcome outcome;
  try {
    TaskRunner::Made made = runner.run(assignment, stop);
    outcome.content = made.content;
    outcome.adopted = made.adopted;
    outcome.cost.bytes = made.bytes;
    outcome.figures = std::move(made.figures);
  } catch (const Interrupted&) {
    outcome.kind = Outcome::Kind::kDropped;
  } catch (const InputDistrusted& e) {
    outcome.kind = Outcome::Kind::kInputUnsound;
    outcome.input = e.input;
    outcome.message = e.what();
  } catch (const UserError& e) {
    return failed(e.what(), true);
  } catch (const std::bad_alloc&) {
    return failed("out of memory; run fewer threads or ranks per machine", false);
  } catch (const std::exception& e) {
    return failed(e.what(), false);
  } catch (...) {
    return failed("unknown exception", false);
  }
  return outcome;
}

}  // namespace

Outcome run_guarded(TaskRunner& runner, const Assignment& assignment, int slot,
                    const std::atomic<bool>& stop) {
  const double began = wall_seconds();
  const double cpu = thread_cpu_seconds();
  Outcome outcome = run_caught(runner, assignment, stop);
  outcome.cost.began = began;
  outcome.cost.seconds = std::max(0.0, wall_seconds() - began);
  outcome.cost.cpu_seconds = thread_cpu_seconds() - cpu;
  outcome.cost.slot = slot;
  return outcome;
}

Slots::Slots(int count, TaskRunner& runner) : runner_(runner) {
  orders_.resize(static_cast<std::size_t>(std::max(1, count)));
  for (int slot = 0; slot < static_cast<int>(orders_.size()); ++slot) {
    threads_.emplace_back([this, slot] { work(slot); });
  }
}

Slots::~Slots() {
  request_stop();
  for (std::thread& thread : threads_) thread.join();
}

void Slots::start(int slot, Assignment assignment) {
  {
    const std::lock_guard lock(mutex_);
    orders_[static_cast<std::size_t>(slot)] = std::move(assignment);
    ++busy_;
  }
  work_signal_.notify_all();
}

std::vector<SlotFinished> Slots::take_finished() {
  const std::lock_guard lock(mutex_);
  return std::exchange(finished_, {});
}

void Slots::wait(std::chrono::microseconds most) {
  std::unique_lock lock(mutex_);
  finished_signal_.wait_for(lock, most, [this] { return !finished_.empty(); });
}

void Slots::request_stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  work_signal_.notify_all();
}

bool Slots::idle() const {
  const std::lock_guard lock(mutex_);
  return busy_ == 0;
}

void Slots::work(int slot) {
  std::optional<Assignment>& order = orders_[static_cast<std::size_t>(slot)];
  std::unique_lock lock(mutex_);
  for (;;) {
    work_signal_.wait(lock, [&] { return stop_ || order; });
    if (!order) return;
    const Assignment assignment = std::move(*order);
    order.reset();
    lock.unlock();
    Outcome outcome;
    if (stop_) {
      outcome.kind = Outcome::Kind::kDropped;
    } else {
      outcome = run_guarded(runner_, assignment, slot, stop_);
    }
    lock.lock();
    --busy_;
    finished_.push_back({slot, std::move(outcome)});
    finished_signal_.notify_one();
  }
}

}  // namespace prt
