#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "bases/depth_basis.h"
#include "bases/pca.h"
#include "methods/common/inputs.h"
#include "methods/lb/tasks.h"
#include "operators/low_rank.h"
#include "store/quantised_io.h"
#include "transport/convex_view.h"

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

/// What lies in the way of a cluster's light, in its rays' terms: walls alone, or anything.
std::optional<MatrixF> walls_of(const SampleSet& samples, const Artifact& rays) {
  const auto cluster = rays.attribute<std::uint32_t>("cluster");
  return convex_walls(samples, HemisphereDirections(rays.attribute<int>("directions")),
                      {samples.cluster_begin[cluster], samples.cluster_begin[cluster + 1],
                       rays.values<std::uint16_t>("distance"), rays.values<std::uint32_t>("sender"),
                       rays.attribute<float>("bound")});
}

// What is left out for its little energy may cost this share of what rounding does, which then is
// 0.5 % more.
constexpr double kTruncationShare = 0.1;

double norm(const MatrixF& m) { return m.cast<double>().norm(); }

/// A cluster's depths in a basis, rounded.
struct RoundedDepths {
  Quantised mean, basis, coefficients;
  [[nodiscard]] MatrixF decode() const {
    return (coefficients.matrix.decode() * basis.matrix.decode()).rowwise() +
           mean.matrix.decode().row(0);
  }
};

RoundedDepths round(const PrincipalComponents& pca, Eigen::Index rank, int bits) {
  MatrixF coefficients = pca.coefficients.leftCols(rank);
  MatrixF basis = pca.basis.topRows(rank);
  // Columns of the coefficients share one size before rounding; the basis takes up the difference.
  balance(coefficients, basis);
  return {quantise(pca.mean.transpose(), 16), quantise(basis, bits), quantise(coefficients, bits)};
}

/// Least rank for which what is left out of the basis is small beside `rounding`, the norm of what
/// rounding all of it costs.
Eigen::Index needed_rank(const PrincipalComponents& pca, double rounding) {
  const double allowed = kTruncationShare * kTruncationShare * rounding * rounding;
  double left_out = 0.0;
  Eigen::Index rank = pca.basis.rows();
  while (rank > 0) {
    left_out += pca.coefficients.col(rank - 1).cast<double>().squaredNorm();
    if (left_out > allowed) break;
    --rank;
  }
  return rank;
}

void put_depths(Artifact& out, const QuantisedMatrix& mean, const QuantisedMatrix& basis,
                const QuantisedMatrix& coefficients) {
  put_quantised(out, "mean", mean, "1", "mean encoded depth, sqrt(t / bound)");
  put_quantised(out, "basis", basis, "1", "visibility basis functions (LB eq. 7)");
  put_quantised(out, "coefficients", coefficients, "1", "samples in that basis (LB eq. 8)");
}

}  // namespace

Artifact run_visibility(const TaskSpec& task, const TaskReader& reader) {
  const auto rays = reader.input(0);
  const int bits = task.parameters["bits"].get<int>();
  Artifact out;
  out.attributes = {{"cluster", rays->attribute<int>("cluster")},
                    {"samples", rays->attribute<int>("samples")},
                    {"bound", rays->attribute<double>("bound")},
                    {"escaped_share", rays->attribute<double>("escaped_share")},
                    {"unoccluded", 0},
                    {"rank", 0},
                    {"energy", 1.0},
                    {"error", 0.0}};
  if (const auto walls = walls_of(shared_samples(reader, 1)->samples, *rays)) {
    out.attributes["unoccluded"] = 1;
    out.put("walls", *walls, "1, 1, 1, m", "walls of the empty space it sees: normals and offsets");
    put_depths(out, {}, {}, {});
    return out;
  }
  const MatrixF z = depths(*rays);
  const PrincipalComponents pca = principal_components(z, task.parameters["rank"].get<int>());
  if (pca.defect > kMostDefect) {
    throw UnsoundData(
        fmt::format("{}: visibility basis is orthonormal to {:.1e} only", task.id, pca.defect));
  }
  RoundedDepths rounded = round(pca, pca.basis.rows(), bits);
  const MatrixF exact = (pca.coefficients * pca.basis).rowwise() + pca.mean.transpose();
  const Eigen::Index rank = needed_rank(pca, norm(rounded.decode() - exact));
  if (rank < pca.basis.rows()) rounded = round(pca, rank, bits);
  const double entries = std::sqrt(static_cast<double>(z.size()));
  const double all = pca.coefficients.cast<double>().squaredNorm();
  const double kept = pca.coefficients.leftCols(rank).cast<double>().squaredNorm();
  out.attributes["rank"] = rank;
  out.attributes["energy"] = all > 0.0 ? pca.energy * kept / all : 1.0;
  out.attributes["rms_error"] =
      std::hypot(pca.rms_error, std::sqrt(std::max(0.0, all - kept)) / entries);
  out.attributes["orthonormality_defect"] = pca.defect;
  out.attributes["error"] = norm(rounded.decode() - z) / entries;  // of z, all steps together
  put_depths(out, rounded.mean.matrix, rounded.basis.matrix, rounded.coefficients.matrix);
  return out;
}

}  // namespace prt::lb
