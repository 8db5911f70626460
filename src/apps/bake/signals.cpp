#include "apps/bake/signals.h"

#include <sys/time.h>
#include <unistd.h>

#include <csignal>

namespace prt {

namespace {

/// Open MPI sends SIGKILL one second after SIGTERM.
constexpr std::chrono::milliseconds kGrace{700};

std::atomic<bool> stop{false};
std::atomic<bool> drain{false};
std::atomic<int> late_exit_code{static_cast<int>(ExitCode::kFailure)};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void on_alarm(int) { _exit(late_exit_code); }

void arm(std::chrono::milliseconds most) {
  itimerval timer{};
  timer.it_value.tv_sec = most.count() / 1000;
  timer.it_value.tv_usec = most.count() % 1000 * 1000;
  setitimer(ITIMER_REAL, &timer, nullptr);
}

void on_stop(int) {
  if (stop.exchange(true)) _exit(static_cast<int>(ExitCode::kInterrupted));
  late_exit_code = static_cast<int>(ExitCode::kInterrupted);
  arm(kGrace);
}

void on_warning(int) { drain = true; }

}  // namespace

void catch_stop_signals() {
  struct sigaction action {};
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  action.sa_handler = on_alarm;
  sigaction(SIGALRM, &action, nullptr);
  action.sa_handler = on_stop;
  for (const int signal : {SIGTERM, SIGINT}) sigaction(signal, &action, nullptr);
  action.sa_handler = on_warning;
  sigaction(SIGUSR1, &action, nullptr);
}

const std::atomic<bool>& stop_flag() { return stop; }
const std::atomic<bool>& drain_flag() { return drain; }

void end_within(std::chrono::milliseconds most, ExitCode code) {
  if (stop) return;  // a signal has set its own limit
  late_exit_code = static_cast<int>(code);
  arm(most);
}

}  // namespace prt
