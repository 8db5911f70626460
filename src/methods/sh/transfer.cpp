#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bases/spherical_harmonics.h"
#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/sh/tasks.h"
#include "operators/low_rank.h"
#include "store/quantised_io.h"
#include "transport/gather.h"
#include "transport/hemisphere.h"

namespace prt::sh {

namespace {

/// Transfer of one sample after the other from what its rays met.
class ShadowedTransfer {
 public:
  ShadowedTransfer(int order, const HemisphereDirections& directions)
      : order_(order), weights_(directions.weights()), rows_(directions.count(), sh_count(order)) {
    for (int i = 0; i < directions.count(); ++i) {
      rows_.row(i) = static_cast<double>(kPi * weights_[static_cast<std::size_t>(i)]) *
                     evaluate_sh(order, directions.direction(i).cast<double>()).transpose();
    }
    const VectorD exact = lambert_sh(order, Vec3d::UnitZ());
    correction_ = exact - rows_.colwise().sum().transpose();
  }

  /// In the world. What the quadrature over all rays misses of the closed form is added in
  /// proportion to the light that gets through: nothing is left of it where all of it does.
  [[nodiscard]] VectorD world(std::span<const std::uint32_t> senders, const Mat3f& frame) const {
    VectorD sum = VectorD::Zero(rows_.cols());
    double open = 0.0;
    for (std::size_t i = 0; i < senders.size(); ++i) {
      if (senders[i] != kEscapedSender) continue;
      sum += rows_.row(static_cast<Eigen::Index>(i)).transpose();
      open += static_cast<double>(weights_[i]);
    }
    if (open == 0.0) return sum;
    return ShRotation(order_, frame.cast<double>()).apply(sum + open * correction_).col(0);
  }

 private:
  int order_;
  std::vector<float> weights_;
  MatrixD rows_;  // directions × order²: share of irradiance, in W/m² per coefficient
  VectorD correction_;
};

/// Clusters that a cluster's rays end in, ascending.
std::vector<std::uint32_t> reached_clusters(const SharedSamples& shared,
                                            std::span<const std::uint32_t> senders) {
  std::vector<bool> reached(shared.samples.clusters(), false);
  for (const std::uint32_t s : senders) {
    if (s < kLostSender) reached[shared.cluster_of_sample.at(s)] = true;
  }
  std::vector<std::uint32_t> clusters;
  for (std::uint32_t c = 0; c < reached.size(); ++c) {
    if (reached[c]) clusters.push_back(c);
  }
  return clusters;
}

/// Σ area · |row|² over a cluster, and over the channels where there is one for all.
double squared_norm(const MatrixF& field, const VectorF& areas) {
  return (areas.cwiseSqrt().asDiagonal() * field).cast<double>().squaredNorm();
}

}  // namespace

Artifact run_direct(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const SampleSet& samples = shared->samples;
  const auto cluster = task.parameters["cluster"].get<std::uint32_t>();
  const int order = task.parameters["order"].get<int>();
  const std::uint32_t begin = samples.cluster_begin.at(cluster);
  const std::uint32_t size = samples.cluster_size(cluster);
  MatrixF transfer(size, sh_count(order));
  std::vector<std::uint32_t> reached;
  double open_share = 1.0;
  if (task.inputs.size() > 1) {
    const auto rays = reader.input(1);
    const auto senders = rays->values<std::uint32_t>("sender");
    const auto count = static_cast<std::size_t>(rays->attribute<int>("directions"));
    if (senders.size() != size * count) throw UnsoundData("rays do not fit the samples");
    open_share = rays->attribute<double>("escaped_share");
    const ShadowedTransfer shadowed(order, HemisphereDirections(static_cast<int>(count)));
    for (std::uint32_t i = 0; i < size; ++i) {
      check_stop(reader);
      transfer.row(i) = shadowed.world(senders.subspan(i * count, count), samples.frame(begin + i))
                            .transpose()
                            .cast<float>();
    }
    reached = reached_clusters(*shared, senders);
  } else {
    for (std::uint32_t i = 0; i < size; ++i) {
      transfer.row(i) =
          lambert_sh(order, samples.normals[begin + i].cast<double>()).transpose().cast<float>();
    }
  }
  Artifact out;
  out.put("transfer", transfer, "sr", "irradiance per SH coefficient of the sky's radiance");
  out.put<std::uint32_t>("reached", reached, {reached.size()}, "1", "clusters that rays end in");
  out.attributes = {{"cluster", cluster},
                    {"samples", size},
                    {"order", order},
                    {"open_share", open_share},
                    {"squared_norm", squared_norm(transfer, cluster_areas(samples, cluster))}};
  return out;
}

namespace {

/// What a cluster sends on of the light that comes to it, channels side by side, each row padded to
/// whole lanes: albedo times the transfer of input `i`. Made once for all tasks of a process.
std::shared_ptr<const MatrixF> exitant_light(const TaskReader& reader, std::size_t i,
                                             const SampleSet& samples, std::uint32_t cluster,
                                             Eigen::Index channels, Eigen::Index functions) {
  const std::string name = "exitant " + reader.input_content(i).hex() + " of " +
                           reader.input_content(1).hex() +
                           fmt::format(" cluster {}, {} channels", cluster, channels);
  return reader.memo().get<MatrixF>(name, [&] {
    const MatrixF transfer = reader.input(i)->matrix("transfer");
    const bool one_for_all = transfer.cols() == functions;
    if (transfer.rows() != samples.cluster_size(cluster) ||
        (!one_for_all && transfer.cols() != channels * functions)) {
      throw UnsoundData("bounced light does not fit the samples");
    }
    const MatrixF albedo = reader.input(1)->matrix("albedo").middleRows(
        samples.cluster_begin[cluster], transfer.rows());
    const Eigen::Index width = padded_to_lanes(channels * functions);
    auto exitant = std::make_shared<MatrixF>(MatrixF::Zero(transfer.rows(), width));
    for (Eigen::Index c = 0; c < channels; ++c) {
      exitant->middleCols(c * functions, functions) =
          albedo.col(c).asDiagonal() *
          transfer.middleCols(one_for_all ? 0 : c * functions, functions);
    }
    return exitant;
  });
}

}  // namespace

Artifact run_bounce(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const SampleSet& samples = shared->samples;
  const auto& p = task.parameters;
  const auto cluster = p["cluster"].get<std::uint32_t>();
  const Eigen::Index functions = sh_count(p["order"].get<int>());
  const auto channels = p["channels"].get<Eigen::Index>();
  const auto senders = p["senders"].get<std::vector<std::uint32_t>>();
  std::vector<std::shared_ptr<const MatrixF>> exitant;
  std::vector<const float*> rows(samples.size(), nullptr);
  for (std::size_t i = 0; i < senders.size(); ++i) {
    check_stop(reader);
    exitant.push_back(exitant_light(reader, i + 3, samples, senders[i], channels, functions));
    for (Eigen::Index k = 0; k < exitant.back()->rows(); ++k) {
      rows[samples.cluster_begin[senders[i]] + static_cast<std::size_t>(k)] =
          exitant.back()->row(k).data();
    }
  }
  const auto rays = reader.input(2);
  const HemisphereDirections directions(rays->attribute<int>("directions"));
  const MatrixF transfer = gather_rows(rays->values<std::uint32_t>("sender"), directions.weights(),
                                       rows, padded_to_lanes(channels * functions))
                               .leftCols(channels * functions);
  Artifact out;
  out.put("transfer", transfer, "sr",
          "irradiance by this bounce per SH coefficient of the sky's radiance, channel by channel");
  out.attributes = {{"cluster", cluster},
                    {"samples", transfer.rows()},
                    {"channels", channels},
                    {"squared_norm", squared_norm(transfer, cluster_areas(samples, cluster)) *
                                         (channels == 1 ? 3.0 : 1.0)}};
  return out;
}

namespace {

struct Compression {
  int bits;
  double tolerance;
};

/// Puts name.left and name.right, whose product is about m, and what the steps cost.
void put_factors(Artifact& out, const std::string& name, const MatrixF& m, const VectorF& areas,
                 const Compression& settings) {
  LeftFactor factor =
      left_factor(m, areas, static_cast<int>(std::min(m.rows(), m.cols())), settings.tolerance);
  MatrixF projected = factor.dual * m;
  balance(factor.functions, projected);
  const Quantised left = quantise(factor.functions, settings.bits);
  const Quantised right = quantise(projected, settings.bits);
  const double total = squared_norm(m, areas);
  const double off = squared_norm(left.matrix.decode() * right.matrix.decode() - m, areas);
  put_quantised(out, name + "_left", left.matrix, "1", "samples in the transfer's left factor");
  put_quantised(out, name + "_right", right.matrix, "sr",
                "right factor: SH functions, channels side by side");
  out.attributes[name + "_rank"] = factor.functions.cols();
  out.attributes[name + "_error_low_rank"] = factor.relative_error;
  out.attributes[name + "_error"] = total > 0.0 ? std::sqrt(off / total) : 0.0;
}

}  // namespace

Artifact run_transfer(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto& p = task.parameters;
  const auto cluster = p["cluster"].get<std::uint32_t>();
  const int order = p["order"].get<int>();
  const VectorF areas = cluster_areas(shared->samples, cluster);
  const Compression settings{p["bits"].get<int>(), p["tolerance"].get<double>()};
  const std::vector<double> window = hann_bands(order, p["window"].get<double>());
  const auto channels = p["channels"].get<Eigen::Index>();
  // Windows scale the light's coefficients; here, so that no player needs to know.
  const auto windowed = [&](const MatrixF& m) {
    MatrixF scaled = m;
    for (Eigen::Index first = 0; first < m.cols(); first += sh_count(order)) {
      for (int l = 0; l < order; ++l) {
        scaled.middleCols(first + sh_index(l, -l), 2 * l + 1) *=
            static_cast<float>(window[static_cast<std::size_t>(l)]);
      }
    }
    return scaled;
  };
  Artifact out;
  out.attributes = {
      {"cluster", cluster}, {"samples", areas.size()}, {"order", order}, {"channels", channels}};
  put_factors(out, "direct", windowed(reader.input(1)->matrix("transfer")), areas, settings);
  if (task.inputs.size() > 2) {
    MatrixF sum = reader.input(2)->matrix("transfer");
    for (std::size_t i = 3; i < task.inputs.size(); ++i) {
      sum += reader.input(i)->matrix("transfer");
    }
    put_factors(out, "indirect", windowed(sum), areas, settings);
  }
  return out;
}

}  // namespace prt::sh
