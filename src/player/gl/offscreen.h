// An OpenGL context without a window or display.
#pragma once

#include <memory>

namespace prt::gl {

/// OpenGL 4.3 core through EGL, current in this thread while it lives: on Mesa's surfaceless
/// platform, else on the first EGL device that can, else on the default display. Throws UserError,
/// one line, where there is none.
class OffscreenContext {
 public:
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace prt::gl
