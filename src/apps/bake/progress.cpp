#include "apps/bake/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/log.h"

namespace prt {

namespace {

constexpr double kLineSeconds = 3.0;
constexpr double kBarSeconds = 0.2;
constexpr std::size_t kBarWidth = 30;

struct Totals {
  std::size_t total = 0;
  std::size_t done = 0;
  double cost_made = 0.0;
  double cost_left = 0.0;
};

Totals sum(const Coordinator& coordinator) {
  Totals t;
  for (const auto& [name, stage] : coordinator.progress()) {
    t.total += stage.total;
    t.done += stage.done;
    t.cost_made += stage.cost_done - stage.cost_adopted;
    t.cost_left += stage.cost_total - stage.cost_done;
  }
  return t;
}

}  // namespace

std::string progress_text(const Coordinator& coordinator, double elapsed) {
  const Totals totals = sum(coordinator);
  std::string stages;
  for (const auto& [name, stage] : coordinator.progress()) {
    if (stage.done == stage.total) continue;
    stages +=
        fmt::format("{}{} {}/{}", stages.empty() ? "; " : ", ", name, stage.done, stage.total);
    const std::size_t made = stage.done - stage.adopted;
    if (made > 0 && elapsed > 0.0) {
      stages += fmt::format(" {:.1f}/s", static_cast<double>(made) / elapsed);
    }
  }
  std::string eta;
  if (totals.cost_made > 0.0 && totals.cost_left > 0.0) {
    eta = fmt::format("; about {:.0f} s", std::ceil(elapsed * totals.cost_left / totals.cost_made));
  }
  const RankCounts ranks = coordinator.ranks();
  std::string busy;
  if (ranks.busy + ranks.idle + ranks.lost > 1) {
    busy = fmt::format("; {} of {} ranks busy", ranks.busy, ranks.busy + ranks.idle);
    if (ranks.lost > 0) busy += fmt::format(", {} lost", ranks.lost);
  }
  return fmt::format("{} of {} tasks{}{}{}", totals.done, totals.total, stages, busy, eta);
}

Progress::Progress(int verbosity) : quiet_(verbosity < 0), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (bar_shown_) std::fputs("\r\033[K", stderr);
}

void Progress::tick(const Coordinator& coordinator, double now) {
  if (quiet_ || coordinator.undone() == 0) return;
  if (began_ < 0.0) began_ = shown_ = now;
  if (now - shown_ < (terminal_ ? kBarSeconds : kLineSeconds)) return;
  shown_ = now;
  const std::string text = progress_text(coordinator, now - began_);
  if (!terminal_) {
    log::info("{}", text);
    return;
  }
  const Totals t = sum(coordinator);
  const std::size_t full = t.total == 0 ? 0 : kBarWidth * t.done / t.total;
  std::fputs(
      fmt::format("\r\033[K[{:=<{}}{:>{}}] {}", "", full, "", kBarWidth - full, text).c_str(),
      stderr);
  std::fflush(stderr);
  bar_shown_ = true;
}

}  // namespace prt
