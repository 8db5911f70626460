#include "player/depth_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "bases/depth_basis.h"
#include "player/dot.h"

namespace prt {

DepthTables::DepthTables(const DepthVisibility& visibility, const SampleSet& samples)
    : samples_(&samples),
      directions_(visibility.directions),
      next_across_(directions_.width() > 1 ? 1 : 0),
      next_along_(directions_.height() > 1 ? directions_.width() : 0),
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

void DepthTables::Scratch::make_room(std::size_t places) {
  cells.make_room(places);
  directions.reserve(4 * places);
}

void DepthTables::within_walls(std::uint32_t sample, const Cluster& cluster,
                               std::span<const ShiningPlace> places,
                               std::span<float> shares) const {
  const Vec3f& normal = samples_->normals[sample];
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto& [to_light, distance] = places[k];
    shares[k] = normal.dot(to_light) <= 0.0F
                    ? 0.0F
                    : wall_visibility(cluster.block->walls, samples_->positions[sample], to_light,
                                      distance, bound_);
  }
}

void DepthTables::weigh(const Cluster& cluster, std::size_t row, std::vector<float>& weights) {
  const QuantisedMatrix& coefficients = cluster.block->coefficients;
  weights.resize(cluster.stride);
  const std::size_t rank = coefficients.cols;  // 0: the mean alone, and no scales
  const float scale = rank == 0 ? 0.0F : coefficients.scales[row];
  std::size_t k = 0;
  with_numbers(coefficients, [&](const auto* numbers) {
    const auto* own = numbers + row * rank;
    for (; k + kLanes <= rank; k += kLanes) {
      const EightFloats eight = scale * load(&cluster.scales[k]) * load(own + k);
      std::memcpy(&weights[k], &eight, sizeof eight);
    }
    for (; k < rank; ++k) weights[k] = scale * cluster.scales[k] * static_cast<float>(own[k]);
  });
  for (; k < weights.size(); ++k) weights[k] = 0.0F;
}

void DepthTables::list_directions(std::size_t places, Scratch& scratch) const {
  if (++scratch.question == 0) {  // numbers have run out: old ones would be taken for new
    std::ranges::fill(scratch.asked, 0U);
    scratch.question = 1;
  }
  const auto count = static_cast<std::size_t>(directions_.count());
  if (scratch.asked.size() < count) {
    scratch.asked.resize(count, 0);
    scratch.depths.resize(count);
  }
  scratch.directions.clear();
  for (std::size_t k = 0; k < places; ++k) {
    for (const std::int32_t d : corners(scratch.cells.corner[k])) {
      std::uint32_t& asked = scratch.asked[static_cast<std::size_t>(d)];
      if (asked == scratch.question) continue;
      asked = scratch.question;
      scratch.directions.push_back(d);
    }
  }
}

void DepthTables::reconstruct(const Cluster& cluster, Scratch& scratch) {
  while (scratch.directions.size() % 4 != 0) {  // the same once more is cheaper than a rest of few
    scratch.directions.push_back(scratch.directions.back());
  }
  std::visit(
      [&](const auto& basis) {
        const auto row = [&](std::int32_t d) {
          return basis.data() + static_cast<std::size_t>(d) * cluster.stride;
        };
        for (std::size_t k = 0; k < scratch.directions.size(); k += 4) {
          const std::int32_t* d = &scratch.directions[k];
          const auto depths =
              dot_of_rows<typename std::remove_cvref_t<decltype(basis)>::value_type>(
                  {row(d[0]), row(d[1]), row(d[2]), row(d[3])}, scratch.weights.data(),
                  cluster.stride);
          for (std::size_t j = 0; j < 4; ++j) {
            const auto direction = static_cast<std::size_t>(d[j]);
            scratch.depths[direction] = cluster.mean[direction] + depths[j];
          }
        }
      },
      cluster.basis);
}

void DepthTables::visibility(std::uint32_t sample, std::uint32_t cluster_index,
                             std::span<const ShiningPlace> places, Scratch& scratch,
                             std::span<float> shares) const {
  const Cluster& cluster = clusters_[cluster_index];
  if (cluster.only_walls) return within_walls(sample, cluster, places, shares);
  const Mat3f to_local = samples_->frame(sample).transpose();
  DirectionCells& cells = scratch.cells;
  cells.make_room(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Vec3f local = to_local * places[k].to_light;
    cells.x[k] = local.x();
    cells.y[k] = local.y();
    cells.z[k] = local.z();
  }
  find_cells(directions_, places.size(), cells);
  list_directions(places.size(), scratch);
  weigh(cluster, sample - samples_->cluster_begin[cluster_index], scratch.weights);
  reconstruct(cluster, scratch);
  for (std::size_t k = 0; k < places.size(); ++k) {
    // The soft test: depth_visibility() of bases/depth_basis.h.
    const float threshold =
        std::sqrt(std::min(places[k].distance, bound_) * (1.0F - bias_) / bound_);
    const auto four = corners(cells.corner[k]);
    const float x = cells.across[k];
    const float y = cells.along[k];
    const std::array<float, 4> weights{(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
    float share = 0.0F;
    for (std::size_t j = 0; j < 4; ++j) {
      const bool seen = scratch.depths[static_cast<std::size_t>(four[j])] >= threshold;
      share += seen ? weights[j] : 0.0F;
    }
    shares[k] = cells.z[k] > 0.0F ? share : 0.0F;
  }
}

}  // namespace prt
