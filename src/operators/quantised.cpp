#include "operators/quantised.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"

namespace prt {

namespace {

template <typename Integer>
double round_rows(const MatrixF& m, float full_scale, std::vector<Integer>& out,
                  std::vector<float>& scales) {
  double squared_error = 0.0;
  out.resize(static_cast<std::size_t>(m.size()));
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    const float largest = m.row(i).cwiseAbs().maxCoeff();
    const float scale = largest / full_scale;
    // A subnormal scale cannot be inverted: such a row is zero to every purpose.
    const bool usable = std::isnormal(scale);
    scales[i] = usable ? scale : 0.0F;
    for (Eigen::Index j = 0; j < m.cols(); ++j) {
      const float integer = usable ? std::round(m(i, j) / scale) : 0.0F;
      out[static_cast<std::size_t>(i * m.cols() + j)] =
          static_cast<Integer>(std::clamp(integer, -full_scale, full_scale));
      const double difference = static_cast<double>(integer) * scales[i] - m(i, j);
      squared_error += difference * difference;
    }
  }
  return squared_error;
}

}  // namespace

MatrixF QuantisedMatrix::decode() const {
  MatrixF m(rows, cols);
  for (std::uint32_t i = 0; i < rows; ++i) {
    for (std::uint32_t j = 0; j < cols; ++j) {
      const std::size_t at = static_cast<std::size_t>(i) * cols + j;
      m(i, j) = bits == 8    ? static_cast<float>(int8[at]) * scales[i]
                : bits == 16 ? static_cast<float>(int16[at]) * scales[i]
                             : float32[at];
    }
  }
  return m;
}

std::size_t QuantisedMatrix::bytes() const {
  return int8.size() + 2 * int16.size() + 4 * float32.size() + (bits == 32 ? 0 : 4 * scales.size());
}

Quantised quantise(const MatrixF& m, int bits) {
  if (!m.allFinite()) {
    throw UnsoundData("a " + std::to_string(m.rows()) + " x " + std::to_string(m.cols()) +
                      " matrix to quantise holds a value that is not finite");
  }
  Quantised result;
  QuantisedMatrix& q = result.matrix;
  q.rows = static_cast<std::uint32_t>(m.rows());
  q.cols = static_cast<std::uint32_t>(m.cols());
  q.bits = bits;
  q.scales.assign(q.rows, 1.0F);
  if (m.size() == 0) return result;
  double squared_error = 0.0;
  if (bits == 8) {
    squared_error = round_rows(m, 127.0F, q.int8, q.scales);
  } else if (bits == 16) {
    squared_error = round_rows(m, 32767.0F, q.int16, q.scales);
  } else {
    q.float32.assign(m.data(), m.data() + m.size());
  }
  const double norm = m.cast<double>().norm();
  result.relative_error = norm > 0.0 ? std::sqrt(squared_error) / norm : 0.0;
  return result;
}

}  // namespace prt
