// How far two pictures are apart.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

namespace prt::test {

struct PictureDifference {
  double mean = 0.0;         ///< absolute, as a share of full scale
  double worst_block = 0.0;  ///< of the means of blocks of 8 × 8 pixels
};

/// Both width × height × 3.
inline PictureDifference difference(std::span<const std::uint8_t> a,
                                    std::span<const std::uint8_t> b, int width, int height) {
  constexpr int kBlock = 8;
  PictureDifference result;
  double total = 0.0;
  for (int top = 0; top < height; top += kBlock) {
    for (int left = 0; left < width; left += kBlock) {
      double sum = 0.0;
      int count = 0;
      for (int y = top; y < std::min(height, top + kBlock); ++y) {
        for (int k = 3 * left; k < 3 * std::min(width, left + kBlock); ++k, ++count) {
          const auto i = static_cast<std::size_t>(3 * width * y + k);
          sum += std::abs(int{a[i]} - int{b[i]}) / 255.0;
        }
      }
      total += sum;
      result.worst_block = std::max(result.worst_block, sum / count);
    }
  }
  result.mean = total / (3.0 * width * height);
  return result;
}

}  // namespace prt::test
