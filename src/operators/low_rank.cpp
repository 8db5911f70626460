#include "operators/low_rank.h"

#include <cmath>

#include "bases/singular.h"

namespace prt {

void balance(MatrixF& left, MatrixF& right) {
  for (Eigen::Index k = 0; k < left.cols(); ++k) {
    const float largest = left.rows() > 0 ? left.col(k).cwiseAbs().maxCoeff() : 0.0F;
    if (!std::isnormal(largest)) continue;
    left.col(k) /= largest;
    right.row(k) *= largest;
  }
}

LeftFactor left_factor(const MatrixF& fields, const VectorF& row_weights, int most,
                       double tolerance) {
  const VectorD row = row_weights.cast<double>().cwiseSqrt();
  const MatrixD weighted = row.asDiagonal() * fields.cast<double>();
  const SingularBasis basis = leading_left_vectors(weighted, most, tolerance);
  const VectorD inverse = row.unaryExpr([](double r) { return r > 0.0 ? 1.0 / r : 0.0; });
  LeftFactor result;
  result.functions = (inverse.asDiagonal() * basis.vectors.transpose()).cast<float>();
  result.dual = (basis.vectors * row.asDiagonal()).cast<float>();
  result.relative_error = std::sqrt(std::max(0.0, 1.0 - basis.energy));
  return result;
}

}  // namespace prt
