// Tells on stderr how far the bake is.
#pragma once

#include <string>

#include "jobs/coordinator.h"

namespace prt {

/// "34 of 120 tasks; rays 20/48 8.3/s, visibility 14/48; about 12 s" (without ETA when nothing was
/// made yet). `elapsed`: seconds since work began.
std::string progress_text(const Coordinator& coordinator, double elapsed);

class Progress {
 public:
  explicit Progress(int verbosity);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows a line when one is due: a bar several times a second on a terminal, else a plain line
  /// every few seconds. `now`: any monotonic clock.
  void tick(const Coordinator& coordinator, double now);

 private:
  bool quiet_;
  bool terminal_;
  bool bar_shown_ = false;
  double began_ = -1.0;
  double shown_ = 0.0;
};

}  // namespace prt
