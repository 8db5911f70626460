// The basis for direct light on a cluster, chosen by the indirect light that it causes: where
// Leonhardt & Bohn (§4.3.1) keep the principal components of example lights, this keeps those parts
// of them that other surfaces see.
#pragma once

#include "base/types.h"

namespace prt {

/// e ≈ Σ_k functions_k · (projections_k · e), with projections · functionsᵀ = I.
struct EffectBasis {
  MatrixF functions;    ///< k × n: mixtures of the examples
  MatrixF projections;  ///< k × n: weights of a sum over the cluster's samples
  VectorF
      strengths;  ///< k, falling: how much of the effect hangs on each; comparable among clusters
  double energy = 1.0;  ///< share of the examples' effect that is kept
  double defect = 0.0;  ///< largest entry of |projections·functionsᵀ − I|
};

/// effect: m × n, the linear map whose result matters (each row already weighted by how much it
/// matters); examples: lights × n. Minimises ‖effect·(E − functionsᵀ·projections·E)‖ over the
/// columns E of examplesᵀ: with the SVD effect·examplesᵀ = U Σ Vᵀ, projections = Uᵀ·effect and
/// functions = Σ⁻¹ Vᵀ·examples. At most `most` functions, fewer where the rest has no effect; none
/// where there is no effect at all.
EffectBasis make_effect_basis(const MatrixF& effect, const MatrixF& examples, int most);

}  // namespace prt
