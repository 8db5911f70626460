// Matrices stored as small integers with a scale per row.
#pragma once

#include <cstdint>
#include <vector>

#include "base/types.h"

namespace prt {

/// value(i, j) = scale[i] · integer(i, j); bits 8 or 16: integers in [-127, 127] or [-32767,
/// 32767], as glTF's normalised BYTE and SHORT times the scale. bits 32: float32 as given, scales
/// all 1.
struct QuantisedMatrix {
  std::uint32_t rows = 0;
  std::uint32_t cols = 0;
  int bits = 32;
  std::vector<float> scales;        ///< rows; value of the integer 1 (not of full scale)
  std::vector<std::int8_t> int8;    ///< rows × cols if bits == 8
  std::vector<std::int16_t> int16;  ///< rows × cols if bits == 16
  std::vector<float> float32;       ///< rows × cols if bits == 32

  [[nodiscard]] MatrixF decode() const;
  [[nodiscard]] std::size_t bytes() const;
};

/// A quantised matrix and how far it is off: ‖Q − M‖_F / ‖M‖_F (0 for an all-zero M).
struct Quantised {
  QuantisedMatrix matrix;
  double relative_error = 0.0;
};

/// Rounds to nearest with the row's largest magnitude as full scale. Throws UnsoundData naming the
/// matrix's shape if an entry is not finite. bits: 8, 16 or 32.
Quantised quantise(const MatrixF& m, int bits);

}  // namespace prt
