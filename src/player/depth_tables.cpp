#include "player/depth_tables.h"

#include <algorithm>

#include "bases/depth_basis.h"
#include "player/dot.h"

namespace prt {

DepthTables::DepthTables(const DepthVisibility& visibility, const SampleSet& samples)
    : samples_(&samples),
      directions_(visibility.directions),
      bound_(visibility.bound),
      bias_(visibility.bias) {
  clusters_.reserve(visibility.clusters.size());
  for (const DepthBlock& block : visibility.clusters) {
    clusters_.push_back(lay_out(block, static_cast<std::size_t>(directions_.count())));
  }
}

DepthTables::Cluster DepthTables::lay_out(const DepthBlock& block, std::size_t directions) {
  Cluster cluster;
  cluster.block = &block;
  cluster.only_walls = block.mean.rows == 0;
  if (cluster.only_walls) return cluster;
  const MatrixF mean = block.mean.decode();
  cluster.mean.assign(mean.data(), mean.data() + mean.size());
  const std::size_t rank = block.basis.rows;
  cluster.stride = (rank + kLanes - 1) / kLanes * kLanes;
  cluster.scales = block.basis.scales;
  cluster.scales.resize(cluster.stride, 0.0F);
  with_numbers(block.basis, [&](const auto* numbers) {
    using Number = std::remove_cvref_t<decltype(*numbers)>;
    std::vector<Number> basis(directions * cluster.stride, Number{0});
    for (std::size_t k = 0; k < rank; ++k) {
      for (std::size_t d = 0; d < directions; ++d) {
        basis[d * cluster.stride + k] = numbers[k * directions + d];
      }
    }
    cluster.basis = std::move(basis);
  });
  return cluster;
}

DepthTables::View DepthTables::at(std::uint32_t sample, std::uint32_t cluster) const {
  View view;
  view.tables_ = this;
  view.cluster_ = &clusters_[cluster];
  view.to_local_ = samples_->frame(sample).transpose();
  view.position_ = samples_->positions[sample];
  if (view.cluster_->only_walls) return view;
  const QuantisedMatrix& coefficients = view.cluster_->block->coefficients;
  thread_local std::vector<float> weights;
  weights.resize(view.cluster_->stride);
  const std::size_t row = sample - samples_->cluster_begin[cluster];
  if (coefficients.cols == 0) {  // the mean alone, and no scales
    std::ranges::fill(weights, 0.0F);
    view.weights_ = weights.data();
    return view;
  }
  const float scale = coefficients.scales[row];
  with_numbers(coefficients, [&](const auto* numbers) {
    const auto* own = numbers + row * coefficients.cols;
    for (std::size_t k = 0; k < coefficients.cols; ++k) {
      weights[k] = scale * view.cluster_->scales[k] * static_cast<float>(own[k]);
    }
  });
  for (std::size_t k = coefficients.cols; k < weights.size(); ++k) weights[k] = 0.0F;
  view.weights_ = weights.data();
  return view;
}

float DepthTables::View::visibility(const Vec3f& to_light, float distance) const {
  const Vec3f local = to_local_ * to_light;
  if (cluster_->only_walls) {
    if (local.z() <= 0.0F) return 0.0F;
    return wall_visibility(cluster_->block->walls, position_, to_light, distance, tables_->bound_);
  }
  return std::visit(
      [&](const auto& basis) {
        const auto depth = [&](int direction) {
          const auto d = static_cast<std::size_t>(direction);
          return cluster_->mean[d] +
                 dot(basis.data() + d * cluster_->stride, weights_, cluster_->stride);
        };
        return depth_visibility(tables_->directions_, depth, local, distance, tables_->bound_,
                                tables_->bias_);
      },
      cluster_->basis);
}

}  // namespace prt
