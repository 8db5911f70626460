// A small RGB picture to draw into. (The player has a Picture of its own.)
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/types.h"

namespace prt {

/// Red, green, blue in [0, 1], as shown (no tone mapping).
using Colour = Vec3f;

inline const Colour kInk(0.1F, 0.1F, 0.1F);

class Drawing {
 public:
  Drawing(int width, int height, const Colour& background);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::span<const std::uint8_t> rgb() const { return rgb_; }
  [[nodiscard]] std::array<std::uint8_t, 3> at(int x, int y) const;

  /// Outside the picture nothing happens.
  void set(int x, int y, const Colour& colour);
  void fill(int x, int y, int width, int height, const Colour& colour);
  /// Another drawing, its top left corner at (x, y).
  void paste(int x, int y, const Drawing& panel);
  /// Top left corner at (x, y); letters are 7 · scale pixels high.
  void text(int x, int y, const std::string& text, const Colour& colour, int scale = 2);

 private:
  int width_, height_;
  std::vector<std::uint8_t> rgb_;
};

/// Colour of t in [0, 1], from dark to light with lightness rising evenly (after viridis).
Colour ramp_colour(float t);
/// Colour of t in [-1, 1]: blue, white, red.
Colour difference_colour(float t);
/// Well told apart for neighbouring i.
Colour index_colour(std::uint32_t i);

}  // namespace prt
