#include "bases/effect_basis.h"

#include <cmath>

#include "bases/singular.h"

namespace prt {

EffectBasis make_effect_basis(const MatrixF& effect, const MatrixF& examples, int most) {
  EffectBasis basis;
  const MatrixF caused = effect * examples.transpose();  // m × lights
  const SingularBasis right = leading_right_vectors(caused.cast<double>(), most);
  const Eigen::Index k = right.vectors.rows();
  const VectorD inverse = right.values.cwiseInverse();
  basis.functions = (inverse.asDiagonal() * right.vectors).cast<float>() * examples;
  const MatrixF left = (inverse.asDiagonal() * right.vectors).cast<float>() * caused.transpose();
  basis.projections = left * effect;
  basis.strengths = right.values.cast<float>();
  basis.energy = right.energy;
  if (k > 0) {
    const MatrixD product =
        basis.projections.cast<double>() * basis.functions.transpose().cast<double>();
    basis.defect = (product - MatrixD::Identity(k, k)).cwiseAbs().maxCoeff();
  }
  return basis;
}

}  // namespace prt
