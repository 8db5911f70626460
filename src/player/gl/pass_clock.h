// Times of the passes of a frame. Internal to player/gl.
#pragma once

#include <epoxy/gl.h>

#include <algorithm>
#include <utility>

#include "base/clock.h"
#include "player/gl/renderer.h"

namespace prt::gl {

/// Adds up what each pass takes, from asking for it until it is done: the same on software and
/// hardware, where timer queries are not.
class PassClock {
 public:
  void measure(bool on) { on_ = on; }
  /// Starts the clock: what was asked for before is done.
  void start() {
    if (!on_) return;
    glFinish();
    since_ = steady_seconds();
  }
  void stop(const char* pass) {
    if (!on_) return;
    glFinish();
    const double now = steady_seconds();
    const auto known = std::find_if(times_.begin(), times_.end(),
                                    [&](const auto& time) { return time.first == pass; });
    (known != times_.end() ? known->second : times_.emplace_back(pass, 0.0).second) +=
        1000.0 * (now - since_);
    since_ = now;
  }
  PassTimes take() { return std::exchange(times_, {}); }

 private:
  bool on_ = false;
  double since_ = 0.0;
  PassTimes times_;
};

}  // namespace prt::gl
