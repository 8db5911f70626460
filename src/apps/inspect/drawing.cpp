#include "apps/inspect/drawing.h"

#include <stb/stb_easy_font.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace prt {

namespace {

/// One corner of a letter's stroke, as stb_easy_font writes it.
struct Corner {
  float x, y, z;
  std::uint8_t colour[4];
};

}  // namespace

Drawing::Drawing(int width, int height, const Colour& background)
    : width_(width), height_(height), rgb_(3 * std::size_t(width) * std::size_t(height)) {
  fill(0, 0, width, height, background);
}

std::array<std::uint8_t, 3> Drawing::at(int x, int y) const {
  const std::size_t i = 3 * (std::size_t(y) * std::size_t(width_) + std::size_t(x));
  return {rgb_[i], rgb_[i + 1], rgb_[i + 2]};
}

void Drawing::set(int x, int y, const Colour& colour) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  const std::size_t i = 3 * (std::size_t(y) * std::size_t(width_) + std::size_t(x));
  for (int c = 0; c < 3; ++c) {
    rgb_[i + c] =
        static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(colour[c], 0.0F, 1.0F)));
  }
}

void Drawing::fill(int x, int y, int width, int height, const Colour& colour) {
  for (int j = y; j < y + height; ++j) {
    for (int i = x; i < x + width; ++i) set(i, j, colour);
  }
}

void Drawing::paste(int x, int y, const Drawing& panel) {
  for (int row = 0; row < panel.height(); ++row) {
    for (int column = 0; column < panel.width(); ++column) {
      const auto rgb = panel.at(column, row);
      set(x + column, y + row, Colour(rgb[0], rgb[1], rgb[2]) / 255.0F);
    }
  }
}

void Drawing::text(int x, int y, const std::string& text, const Colour& colour, int scale) {
  std::vector<Corner> corners(64 * text.size() + 64);  // about 17 a letter are used
  std::string copy = text;                             // the font's interface is not const
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Corner)));
  for (int q = 0; q < quads; ++q) {
    const Corner& low = corners[4 * q];
    const Corner& high = corners[4 * q + 2];
    fill(x + scale * static_cast<int>(low.x), y + scale * static_cast<int>(low.y),
         scale * static_cast<int>(high.x - low.x), scale * static_cast<int>(high.y - low.y),
         colour);
  }
}

Colour ramp_colour(float t) {
  static const std::array<Colour, 6> kStops = {
      Colour(0.267F, 0.005F, 0.329F), Colour(0.254F, 0.265F, 0.530F),
      Colour(0.164F, 0.471F, 0.558F), Colour(0.135F, 0.659F, 0.518F),
      Colour(0.478F, 0.821F, 0.318F), Colour(0.993F, 0.906F, 0.144F)};
  const float at = std::clamp(t, 0.0F, 1.0F) * static_cast<float>(kStops.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const float f = at - static_cast<float>(i);
  return (1.0F - f) * kStops[i] + f * kStops[i + 1];
}

Colour difference_colour(float t) {
  static const Colour kLow(0.13F, 0.25F, 0.70F);
  static const Colour kHigh(0.75F, 0.10F, 0.12F);
  const float share = std::min(std::abs(t), 1.0F);
  return (1.0F - share) * Colour::Ones() + share * (t < 0 ? kLow : kHigh);
}

Colour index_colour(std::uint32_t i) {
  constexpr float kGolden = 0.61803399F;  // hues of any few successive indices lie far apart
  const float hue = 6.0F * std::fmod(kGolden * static_cast<float>(i), 1.0F);
  const float saturation = i % 3 == 0 ? 0.85F : i % 3 == 1 ? 0.6F : 0.7F;
  const float value = i % 3 == 1 ? 0.95F : i % 3 == 2 ? 0.7F : 0.85F;
  const auto channel = [&](float shift) {
    const float k = std::fmod(shift + hue, 6.0F);
    return value * (1.0F - saturation * std::clamp(std::min(k, 4.0F - k), 0.0F, 1.0F));
  };
  return {channel(5.0F), channel(3.0F), channel(1.0F)};
}

}  // namespace prt
