// Random matrices for tests of bases and operators.
#pragma once

#include <cmath>

#include "base/random.h"
#include "base/types.h"

namespace prt::test {

/// Entries uniform in [-1, 1).
inline MatrixD random_matrix(Eigen::Index rows, Eigen::Index cols, std::uint64_t stream) {
  MatrixD m(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i) {
    Random random(stream, static_cast<std::uint64_t>(i));
    for (Eigen::Index j = 0; j < cols; ++j) m(i, j) = 2.0 * random.uniform() - 1.0;
  }
  return m;
}

/// Product of random factors whose singular values fall by about `decay` from one to the next.
inline MatrixD falling_matrix(Eigen::Index rows, Eigen::Index cols, Eigen::Index rank, double decay,
                              std::uint64_t stream) {
  MatrixD left = random_matrix(rows, rank, stream);
  for (Eigen::Index k = 0; k < rank; ++k) left.col(k) *= std::pow(decay, static_cast<double>(k));
  return left * random_matrix(rank, cols, stream + 1);
}

/// Uniform in [0.5, 1.5): areas of cells.
inline VectorF random_areas(Eigen::Index count, std::uint64_t stream) {
  VectorF areas(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    areas[i] = 0.5F + Random(stream, static_cast<std::uint64_t>(i)).uniform();
  }
  return areas;
}

}  // namespace prt::test
