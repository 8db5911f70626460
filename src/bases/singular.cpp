#include "bases/singular.h"

#include <Spectra/MatOp/DenseSymMatProd.h>
#include <Spectra/SymEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>
#include <string>

#include "base/error.h"

namespace prt {

namespace {

struct Eigenpairs {
  Eigen::MatrixXd vectors;  // columns, by falling eigenvalue
  VectorD values;
};

/// Below this size, or when a large part of the spectrum is wanted, the full solver is faster.
constexpr Eigen::Index kSmall = 96;

Eigenpairs all_pairs(const Eigen::MatrixXd& gram, Eigen::Index k) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  return {solver.eigenvectors().rightCols(k).rowwise().reverse(),
          solver.eigenvalues().tail(k).reverse()};
}

Eigenpairs leading_pairs(const Eigen::MatrixXd& gram, Eigen::Index k) {
  const Eigen::Index n = gram.rows();
  if (n <= kSmall || 3 * k >= n) return all_pairs(gram, k);
  const Spectra::DenseSymMatProd<double> product(gram);
  const Eigen::Index subspace = std::min(n, std::max<Eigen::Index>(2 * k + 10, 20));
  Spectra::SymEigsSolver<Spectra::DenseSymMatProd<double>> solver(
      const_cast<Spectra::DenseSymMatProd<double>&>(product), k, subspace);
  try {
    solver.init();
    constexpr int kMostRestarts = 200;
    const auto converged = solver.compute(Spectra::SortRule::LargestAlge, kMostRestarts, 1e-9);
    if (solver.info() == Spectra::CompInfo::Successful && converged >= k) {
      return {solver.eigenvectors(), solver.eigenvalues()};
    }
  } catch (const std::runtime_error&) {
    // Matrices of low rank break the iteration down: its subspace is larger than their range.
  }
  return all_pairs(gram, k);
}

/// Replaces the rows by an orthonormal basis of the same leading spaces, signs kept.
void orthonormalise(MatrixD& rows) {
  const Eigen::Index k = rows.rows();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows.transpose());
  Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(rows.cols(), k);
  for (Eigen::Index i = 0; i < k; ++i) {
    if (qr.matrixQR()(i, i) < 0.0) q.col(i) = -q.col(i);
  }
  rows = q.transpose();
}

/// How many of the falling eigenvalues are needed and real.
Eigen::Index kept_rank(const VectorD& eigenvalues, double total, double tolerance) {
  constexpr double kZeroSigma = 1e-7;
  double left = total;
  Eigen::Index k = 0;
  while (k < eigenvalues.size() && eigenvalues[k] > kZeroSigma * kZeroSigma * eigenvalues[0] &&
         eigenvalues[k] > 0.0 && left > tolerance * tolerance * total) {
    left -= eigenvalues[k];
    ++k;
  }
  return k;
}

}  // namespace

double orthonormality_defect(const MatrixD& rows) {
  if (rows.rows() == 0) return 0.0;
  const MatrixD gram = rows * rows.transpose();
  return (gram - MatrixD::Identity(rows.rows(), rows.rows())).cwiseAbs().maxCoeff();
}

SingularBasis leading_right_vectors(const MatrixD& m, Eigen::Index most, double tolerance) {
  if (!m.allFinite()) {
    throw UnsoundData("a " + std::to_string(m.rows()) + " x " + std::to_string(m.cols()) +
                      " matrix for a basis holds a value that is not finite");
  }
  SingularBasis result;
  result.vectors.resize(0, m.cols());
  result.values.resize(0);
  // Scaling by the largest entry keeps squares in range for depths and lights of any unit.
  const double scale = m.size() > 0 ? m.cwiseAbs().maxCoeff() : 0.0;
  most = std::min({most, m.rows(), m.cols()});
  if (!(scale > 0.0) || most <= 0) {
    result.energy = scale > 0.0 ? 0.0 : 1.0;
    return result;
  }
  const MatrixD a = m / scale;
  const double total = a.squaredNorm();
  const bool wide = a.cols() > a.rows();
  Eigen::MatrixXd gram =
      Eigen::MatrixXd::Zero(wide ? a.rows() : a.cols(), wide ? a.rows() : a.cols());
  if (wide) {
    gram.selfadjointView<Eigen::Lower>().rankUpdate(a);
  } else {
    gram.selfadjointView<Eigen::Lower>().rankUpdate(a.transpose());
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  const Eigenpairs pairs = leading_pairs(gram, most);
  const Eigen::Index k = kept_rank(pairs.values, total, tolerance);
  if (wide) {
    result.vectors = pairs.vectors.leftCols(k).transpose() * a;
    for (Eigen::Index i = 0; i < k; ++i) result.vectors.row(i).normalize();
  } else {
    result.vectors = pairs.vectors.leftCols(k).transpose();
  }
  if (k > 0) orthonormalise(result.vectors);
  result.values = scale * pairs.values.head(k).cwiseMax(0.0).cwiseSqrt();
  result.energy = std::min(1.0, pairs.values.head(k).sum() / total);
  result.defect = orthonormality_defect(result.vectors);
  return result;
}

SingularBasis leading_left_vectors(const MatrixD& m, Eigen::Index most, double tolerance) {
  return leading_right_vectors(m.transpose(), most, tolerance);
}

}  // namespace prt
