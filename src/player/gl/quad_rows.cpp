#include "player/gl/quad_rows.h"

#include <algorithm>

namespace prt::gl {
namespace {

template <typename T>
T value_as(const QuantisedMatrix& m, std::size_t index) {
  if (m.bits == 8) return static_cast<T>(m.int8[index]);
  if (m.bits == 16) return static_cast<T>(m.int16[index]);
  return static_cast<T>(m.float32[index]);
}

}  // namespace

int QuadRows::bits_of(const std::vector<const QuantisedMatrix*>& matrices) {
  int bits = 8;
  for (const QuantisedMatrix* m : matrices) {
    if (m->rows > 0 && m->cols > 0) bits = std::max(bits, m->bits);
  }
  return bits;
}

void QuadRows::append(const QuantisedMatrix& matrix, std::size_t row, std::size_t column) {
  const std::size_t index = row * matrix.cols + column;
  if (bits_ == 8) int8_.push_back(value_as<std::int8_t>(matrix, index));
  if (bits_ == 16) int16_.push_back(value_as<std::int16_t>(matrix, index));
  if (bits_ == 32) float32_.push_back(value_as<float>(matrix, index));
}

void QuadRows::pad() {
  while (int8_.size() % 4 != 0) int8_.push_back(0);
  while (int16_.size() % 4 != 0) int16_.push_back(0);
  while (float32_.size() % 4 != 0) float32_.push_back(0.0F);
}

std::uint32_t QuadRows::quads() const {
  return quads_for(int8_.size() + int16_.size() + float32_.size());
}

TexelBuffer QuadRows::upload() const {
  if (bits_ == 8) return gl::texels(GL_RGBA8I, 4, int8_);
  if (bits_ == 16) return gl::texels(GL_RGBA16I, 8, int16_);
  return gl::texels(GL_RGBA32F, 16, float32_);
}

}  // namespace prt::gl
