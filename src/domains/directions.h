// Equal-area directions over the hemisphere, on a grid, so that the four directions next to any
// given one are found by arithmetic (Leonhardt & Bohn, figure 2).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace prt {

/// width × height cells of a square, mapped by Shirley & Chiu's concentric map and z = 1 - r² onto
/// the hemisphere: every cell covers the solid angle 2π / count. Directions are in the sample's
/// frame, +z is the normal.
class HemisphereDirections {
 public:
  /// The count next to `count` (itself, if it will do; the smaller of two) whose factors make a
  /// grid of an aspect below 2; from 1 to 2^30.
  static int nearest_count(int count);

  /// Grid of exactly `count` cells, as square as its factors allow. Throws UserError unless
  /// `count` is its own nearest_count. At most 2^30.
  explicit HemisphereDirections(int count);

  [[nodiscard]] int count() const { return width_ * height_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Direction i = y · width + x at its cell's centre; unit, z > 0.
  [[nodiscard]] const Vec3f& direction(int i) const { return directions_[i]; }
  /// Cosine weights: weight[i] ∝ cosθ_i, sum 1. Irradiance of radiance L_i is π Σ weight[i]·L_i.
  [[nodiscard]] const std::vector<float>& weights() const { return weights_; }

  /// The four nearest directions of a local unit direction (z > 0) and their bilinear weights,
  /// sum 1.
  struct Lookup {
    std::array<int, 4> index;
    std::array<float, 4> weight;
  };
  [[nodiscard]] Lookup lookup(const Vec3f& local) const;

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<Vec3f> directions_;
  std::vector<float> weights_;
};

}  // namespace prt
