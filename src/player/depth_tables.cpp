#include "player/depth_tables.h"

#include <array>

#include "bases/depth_basis.h"

namespace prt {
namespace {

constexpr std::size_t kLanes = 8;  // floats of an AVX2 register

float dot(const float* a, const float* b, std::size_t count) {
  std::array<float, kLanes> sums{};
  for (std::size_t i = 0; i < count; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  }
  return ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]));
}

}  // namespace

DepthTables::DepthTables(const DepthVisibility& visibility, const SampleSet& samples)
    : samples_(&samples),
      directions_(visibility.directions),
      bound_(visibility.bound),
      bias_(visibility.bias) {
  clusters_.reserve(visibility.clusters.size());
  for (std::size_t c = 0; c < visibility.clusters.size(); ++c) {
    clusters_.push_back(decode(visibility.clusters[c],
                               static_cast<std::size_t>(directions_.count()),
                               samples.cluster_size(c)));
  }
}

DepthTables::Cluster DepthTables::decode(const DepthBlock& block, std::size_t directions,
                                         std::size_t samples) {
  Cluster cluster;
  cluster.only_walls = block.mean.rows == 0;
  cluster.walls = block.walls;
  if (cluster.only_walls) return cluster;
  const MatrixF mean = block.mean.decode();
  const MatrixF basis = block.basis.decode();
  const MatrixF coefficients = block.coefficients.decode();
  const auto rank = static_cast<std::size_t>(basis.rows());
  cluster.stride = (1 + rank + kLanes - 1) / kLanes * kLanes;
  cluster.basis.assign(directions * cluster.stride, 0.0F);
  cluster.coefficients.assign(samples * cluster.stride, 0.0F);
  for (std::size_t d = 0; d < directions; ++d) {
    float* row = cluster.basis.data() + d * cluster.stride;
    row[0] = mean(0, static_cast<Eigen::Index>(d));
    for (std::size_t k = 0; k < rank; ++k) {
      row[1 + k] = basis(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(d));
    }
  }
  for (std::size_t i = 0; i < samples; ++i) {
    float* row = cluster.coefficients.data() + i * cluster.stride;
    row[0] = 1.0F;
    for (std::size_t k = 0; k < rank; ++k) {
      row[1 + k] = coefficients(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
  }
  return cluster;
}

float DepthTables::visibility(std::uint32_t sample, std::uint32_t cluster, const Vec3f& to_light,
                              float distance) const {
  const Cluster& table = clusters_[cluster];
  const Vec3f local = samples_->frame(sample).transpose() * to_light;
  if (table.only_walls) {
    if (local.z() <= 0.0F) return 0.0F;
    return wall_visibility(table.walls, samples_->positions[sample], to_light, distance, bound_);
  }
  const std::size_t place = sample - samples_->cluster_begin[cluster];
  const float* coefficients = table.coefficients.data() + place * table.stride;
  const auto depth = [&](int direction) {
    return dot(table.basis.data() + static_cast<std::size_t>(direction) * table.stride,
               coefficients, table.stride);
  };
  return depth_visibility(directions_, depth, local, distance, bound_, bias_);
}

}  // namespace prt
