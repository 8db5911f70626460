// Quantised matrices as shaders read them: integers stay integers, four to a texel. Internal to
// player/gl.
#pragma once

#include <cstdint>
#include <vector>

#include "operators/quantised.h"
#include "player/gl/objects.h"

namespace prt::gl {

/// Rows of any length, each padded with zeros to whole texels of four values. Values of all
/// matrices are kept as integers of the widest bits among them, or all as floats; a value is to be
/// multiplied by its matrix's scale of the row.
class QuadRows {
 public:
  explicit QuadRows(int bits) : bits_(bits) {}
  /// 8, 16 or 32: what all these matrices fit into.
  static int bits_of(const std::vector<const QuantisedMatrix*>& matrices);

  void append(const QuantisedMatrix& matrix, std::size_t row, std::size_t column);
  /// Ends a row, or a part of one that starts on a texel of its own.
  void pad();
  /// Texels so far; a part must not be open.
  [[nodiscard]] std::uint32_t quads() const;
  [[nodiscard]] bool floats() const { return bits_ == 32; }
  [[nodiscard]] TexelBuffer upload() const;

 private:
  int bits_;
  std::vector<std::int8_t> int8_;
  std::vector<std::int16_t> int16_;
  std::vector<float> float32_;
};

/// Texels that a row of so many values takes.
inline std::uint32_t quads_for(std::size_t values) {
  return static_cast<std::uint32_t>((values + 3) / 4);
}

}  // namespace prt::gl
