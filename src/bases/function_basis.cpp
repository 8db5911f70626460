#include "bases/function_basis.h"

#include <algorithm>
#include <cmath>

#include "bases/singular.h"

namespace prt {

FunctionBasis make_function_basis(const MatrixF& examples, const VectorF& areas, int most,
                                  double tolerance) {
  const Eigen::Index n = examples.cols();
  const VectorD root_area = areas.cast<double>().cwiseSqrt();
  const VectorD constant = root_area / root_area.norm();
  MatrixD weighted = examples.cast<double>() * root_area.asDiagonal();
  const double total = weighted.squaredNorm();
  const VectorD along_constant = weighted * constant;
  weighted.noalias() -= along_constant * constant.transpose();

  const double left = weighted.squaredNorm();
  // What rounding leaves of even light is noise that may point anywhere, along the constant too.
  constexpr double kNoise = 1e-7;
  const double tolerance_of_rest =
      left > kNoise * kNoise * total ? tolerance * std::sqrt(total / left) : 1.0;
  const SingularBasis rest =
      leading_right_vectors(weighted, std::min<Eigen::Index>(most - 1, n - 1), tolerance_of_rest);
  MatrixD vectors(1 + rest.vectors.rows(), n);
  vectors.row(0) = constant.transpose();
  vectors.bottomRows(rest.vectors.rows()) = rest.vectors;

  FunctionBasis basis;
  const double root_count =
      std::sqrt(static_cast<double>(std::max<Eigen::Index>(1, examples.rows())));
  basis.coefficient_rms.resize(vectors.rows());
  basis.coefficient_rms[0] = static_cast<float>(along_constant.norm() / root_count);
  basis.coefficient_rms.tail(rest.values.size()) = (rest.values / root_count).cast<float>();
  const double kept = along_constant.squaredNorm() + rest.values.squaredNorm();
  basis.energy = total > 0.0 ? std::min(1.0, kept / total) : 1.0;
  basis.error = std::sqrt(std::max(0.0, 1.0 - basis.energy));
  const MatrixD functions = vectors * root_area.cwiseInverse().asDiagonal();
  basis.functions = functions.cast<float>();
  basis.defect = orthonormality_defect(basis.functions.cast<double>() * root_area.asDiagonal());
  return basis;
}

}  // namespace prt
