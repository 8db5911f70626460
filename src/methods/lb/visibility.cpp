#include <fmt/format.h>

#include "base/error.h"
#include "bases/depth_basis.h"
#include "bases/pca.h"
#include "methods/lb/tasks.h"
#include "operators/low_rank.h"
#include "store/quantised_io.h"

namespace prt::lb {

namespace {

// The bound of the contract: a basis that is less orthonormal is a numerical failure, not a result.
constexpr double kMostDefect = 1e-5;

MatrixF depths(const Artifact& rays) {
  const auto packed = rays.values<std::uint16_t>("distance");
  const auto& dims = rays.at("distance").dims;
  MatrixF z(static_cast<Eigen::Index>(dims[0]), static_cast<Eigen::Index>(dims[1]));
  for (std::size_t i = 0; i < packed.size(); ++i) z.data()[i] = unpack_depth(packed[i]);
  return z;
}

}  // namespace

Artifact run_visibility(const TaskSpec& task, const TaskReader& reader) {
  const auto rays = reader.input(0);
  const int bits = task.parameters["bits"].get<int>();
  const MatrixF z = depths(*rays);
  PrincipalComponents pca = principal_components(z, task.parameters["rank"].get<int>());
  if (pca.defect > kMostDefect) {
    throw UnsoundData(
        fmt::format("{}: visibility basis is orthonormal to {:.1e} only", task.id, pca.defect));
  }
  Artifact out;
  out.attributes = {{"cluster", rays->attribute<int>("cluster")},
                    {"samples", z.rows()},
                    {"bound", rays->attribute<double>("bound")},
                    {"rank", pca.basis.rows()},
                    {"energy", pca.energy},
                    {"rms_error", pca.rms_error},
                    {"orthonormality_defect", pca.defect}};
  // Columns of the coefficients share one size before rounding; the basis takes up the difference.
  balance(pca.coefficients, pca.basis);
  const Quantised mean = quantise(pca.mean.transpose(), 16);
  const Quantised basis = quantise(pca.basis, bits);
  const Quantised coefficients = quantise(pca.coefficients, bits);
  const MatrixF again = (coefficients.matrix.decode() * basis.matrix.decode()).rowwise() +
                        mean.matrix.decode().row(0);
  const double error = (again - z).cast<double>().norm() / std::sqrt(static_cast<double>(z.size()));
  out.attributes["error"] = error;  // root mean square of z, all steps together
  put_quantised(out, "mean", mean.matrix, "1", "mean encoded depth, sqrt(t / bound)");
  put_quantised(out, "basis", basis.matrix, "1", "visibility basis functions (LB eq. 7)");
  put_quantised(out, "coefficients", coefficients.matrix, "1", "samples in that basis (LB eq. 8)");
  return out;
}

}  // namespace prt::lb
