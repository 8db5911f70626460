#include "bases/pca.h"

#include <cmath>

#include "bases/singular.h"

namespace prt {

PrincipalComponents principal_components(const MatrixF& rows, int most, double tolerance) {
  PrincipalComponents result;
  MatrixD centred = rows.cast<double>();
  const Eigen::RowVectorXd mean = centred.colwise().mean();
  result.mean = mean.cast<float>();
  centred.rowwise() -= result.mean.cast<double>().transpose();
  // What rounding of the mean leaves of equal rows is noise, not a component.
  constexpr double kNoise = 1e-6;
  const double largest = rows.cwiseAbs().maxCoeff();
  if (centred.cwiseAbs().maxCoeff() <= kNoise * largest) centred.setZero();
  const SingularBasis basis = leading_right_vectors(centred, most, tolerance);
  result.basis = basis.vectors.cast<float>();
  const MatrixD coefficients = centred * basis.vectors.transpose();
  result.coefficients = coefficients.cast<float>();
  result.energy = basis.energy;
  const double left = std::max(0.0, centred.squaredNorm() - coefficients.squaredNorm());
  result.rms_error = std::sqrt(left / static_cast<double>(rows.size()));
  result.defect = orthonormality_defect(result.basis.cast<double>());
  return result;
}

}  // namespace prt
