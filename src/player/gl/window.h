// A GLFW window with Dear ImGui in it, and what happened to it since last asked. Internal to
// player/gl.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "player/gl/controls.h"

namespace prt::gl {

/// Input that the panel did not take.
struct Input {
  Drag left, right;
  float wheel = 0.0F;
  bool shift = false;
  Vec3f walk = Vec3f::Zero();  ///< keys held: -1, 0 or 1 each; right, up, ahead
  std::vector<int> pressed;    ///< upper-case letters and the keys below
};
inline constexpr int kKeyPanel = 1;

class Window {
 public:
  /// Throws UserError where there is no display, or no OpenGL 4.3 on it.
  Window(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  [[nodiscard]] bool open() const;
  /// Of the image, pixels.
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// Takes input and begins a frame of the panel.
  Input begin();
  /// Draws the panel over the picture and shows both.
  void end();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace prt::gl
