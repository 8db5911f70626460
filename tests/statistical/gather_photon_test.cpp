// The two solvers against each other: light gathered over stored rays, compressed, and photons.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "base/random.h"
#include "methods/lb/lb.h"
#include "methods/lb/near.h"
#include "methods/lb/tasks.h"
#include "scene/load.h"
#include "statistical/z_test.h"
#include "store/quantised_io.h"
#include "support/partial_bake.h"
#include "transport/direct.h"
#include "transport/free_space.h"
#include "transport/hemisphere.h"
#include "transport/photons.h"

namespace prt {
namespace {

constexpr std::size_t kLights = 8;
constexpr Eigen::Index kChannels = 3;
// Of the samples' diagonal. Nearer to a wall one cell holds most of the light, and the noise of
// both solvers there would hide what is looked for.
constexpr float kClearance = 0.05F;
// Some 200 per cell: photons start at these points and are divided by the areas they measure, and
// with the bake's own 32 the areas are wrong by 18 %.
constexpr std::uint64_t kCellPoints = 600000;
constexpr int kBatches = 48;
constexpr std::uint64_t kPhotonsPerBatch = 8000;    // from each cluster
constexpr std::uint64_t kReceiversPerBatch = 2000;  // on all the surface
// Few: what they miss of one receiver the next ones see, each turned at random.
constexpr int kReceiverDirections = 504;
// Gather's own bias: finitely many directions, cells as senders, snapshot bases and compression.
// Of the scene's mean indirect irradiance under the same light; photons have none of these.
constexpr double kBias = 0.01;

struct Setting {
  Setting() : scene(load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/gallery.glb")) {
    OptionValues options = test::default_options(lb_method());
    options.set("samples.count", 3000);
    options.set("samples.cluster_size", 300);
    options.set("compression.bits", 16);
    options.set("compression.tolerance", 1e-5);
    bake = std::make_unique<test::InProcessBake>(scene, options);
    plan = bake->run(lb_method());
    samples = test::samples_of(*bake);
    measure_cells();
    functions = lb::get_light_functions(*bake->result("light_functions"));
    const auto lights =
        free_positions(scene, bake->caster(), samples, kClearance * samples_diagonal(samples),
                       stream_key(99, "held-out lights"), 0, kLights);
    const MatrixF direct =
        direct_irradiance(scene, bake->caster(), samples, 0,
                          static_cast<std::uint32_t>(samples.size()), lights, 0.0F);
    coefficients = MatrixF::Zero(functions.functions.count(), kLights);
    projected = MatrixF::Zero(static_cast<Eigen::Index>(samples.size()), kLights);
    for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
      const Eigen::Index first = samples.cluster_begin[c];
      const Eigen::Index n = samples.cluster_size(c);
      const Eigen::Index k = functions.functions.of(c);
      const MatrixF own = functions.projections.block(first, 0, n, k).transpose() *
                          direct.middleCols(first, n).transpose();
      coefficients.middleRows(functions.functions.begin[c], k) = own;
      projected.middleRows(first, n) = functions.functions.values.block(first, 0, n, k) * own;
    }
  }
  void measure_cells() {
    const SenderSearch search(scene, samples);
    const std::vector<double> cumulative = cumulative_areas(scene);
    points = draw_cell_points(scene, bake->caster(), samples, search, cumulative, kCellPoints, 0,
                              kCellPoints, stream_key(99, "cells"));
    const auto area = static_cast<float>(cumulative.back() / kCellPoints);
    std::fill(samples.areas.begin(), samples.areas.end(), 0.0F);
    for (const std::uint32_t s : points.samples) samples.areas[s] += area;
    for (float& a : samples.areas) a = std::max(a, 0.5F * area);
  }
  /// Area means of irradiance (samples × channels·lights) over each cluster.
  [[nodiscard]] MatrixD cluster_means(const MatrixF& irradiance) const {
    MatrixD means(samples.clusters(), irradiance.cols());
    for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
      const VectorD areas = cluster_areas(samples, c).cast<double>();
      means.row(c) =
          areas.transpose() / areas.sum() *
          irradiance.middleRows(samples.cluster_begin[c], samples.cluster_size(c)).cast<double>();
    }
    return means;
  }

  Scene scene;
  std::unique_ptr<test::InProcessBake> bake;
  Plan plan;
  SampleSet samples;
  CellPoints points;
  lb::LightFunctions functions;
  MatrixF coefficients;  ///< functions × lights
  MatrixF projected;     ///< samples × lights: direct light as the functions hold it
};

/// What near senders add to all irradiance (samples × channels · lights), as the package has it.
void add_near(const Setting& s, MatrixF& all) {
  NearTransfer stored;
  for (std::uint32_t c = 0; c < s.samples.clusters(); ++c) {
    lb::append_near(*s.bake->result(numbered("near", c)), stored);
  }
  GatherEntries near{stored.begin, stored.senders, {}};
  for (const auto share : stored.shares)
    near.shares.push_back(static_cast<float>(share) / kUnitShare);
  const MatrixF albedo = s.bake->result(kAlbedoTask)->matrix("albedo");
  std::vector<MatrixF> received;
  std::vector<MatrixF> sent(kChannels, s.projected);
  for (int bounce = 0; bounce < lb::kNearBounces; ++bounce) {
    received = gather_fields(near, albedo, sent);
    for (Eigen::Index c = 0; c < kChannels; ++c) sent[c] = s.projected + received[c];
  }
  for (Eigen::Index c = 0; c < kChannels; ++c) all.middleCols(c * kLights, kLights) += received[c];
}

/// Irradiance that the finished transfer gives, samples × (channels · lights).
MatrixF gathered(const Setting& s) {
  MatrixF all(static_cast<Eigen::Index>(s.samples.size()), kChannels * kLights);
  const auto& begin = s.functions.functions.begin;
  for (const std::string& id : s.plan.results) {
    if (!id.starts_with("transfer")) continue;
    const auto part = s.bake->result(id);
    const auto cluster = part->attribute<std::uint32_t>("cluster");
    const MatrixF left = get_quantised(*part, "left").decode();
    const MatrixF right = get_quantised(*part, "right").decode();
    const auto senders = part->values<std::uint32_t>("senders");
    const Eigen::Index width = right.cols() / kChannels;
    MatrixF kept(width, kLights);
    Eigen::Index row = 0;
    for (const auto c : senders) {
      const Eigen::Index k = begin[c + 1] - begin[c];
      kept.middleRows(row, k) = s.coefficients.middleRows(begin[c], k);
      row += k;
    }
    for (Eigen::Index c = 0; c < kChannels; ++c) {
      all.block(s.samples.cluster_begin[cluster], c * kLights, left.rows(), kLights) =
          left * (right.middleCols(c * width, width) * kept);
    }
  }
  add_near(s, all);
  return all;
}

/// The same by photons: one batch with random numbers of its own. All clusters send the same
/// number of photons, so the weight of a photon differs with the cluster's area.
MatrixF shot(const Setting& s, const SenderSearch& search, int batch) {
  MatrixF all = MatrixF::Zero(static_cast<Eigen::Index>(s.samples.size()), kChannels * kLights);
  for (std::uint32_t c = 0; c < s.samples.clusters(); ++c) {
    const MatrixF own =
        s.projected.middleRows(s.samples.cluster_begin[c], s.samples.cluster_size(c)).transpose();
    PhotonSettings settings;
    settings.photons = kPhotonsPerBatch;
    settings.stream = stream_key(static_cast<std::uint64_t>(batch), numbered("photons", c));
    all += shoot_photons(s.scene, s.bake->caster(), s.samples, search, s.points, c, own, kChannels,
                         settings)
               .irradiance;
  }
  return all;
}

/// Points uniform in area over all cells as receivers, each turned at random about its normal; its
/// radius and area mean nothing.
SampleSet receivers_at(const Setting& s, const CellPoints& points, std::uint64_t stream) {
  SampleSet receivers;
  for (std::size_t i = 0; i < points.samples.size(); ++i) {
    Random random(stream, i);
    const Vec3f front = triangle_normal(s.scene, points.triangles[i]);
    const bool is_front = front.dot(s.samples.normals[points.samples[i]]) > 0.0F;
    const Vec3f normal = is_front ? front : Vec3f(-front);
    const float angle = 2.0F * kPi * random.uniform();
    receivers.positions.push_back(triangle_point(
        s.scene, points.triangles[i], points.barycentric[2 * i], points.barycentric[2 * i + 1]));
    receivers.normals.push_back(normal);
    receivers.tangents.push_back(Eigen::AngleAxisf(angle, normal) * normal.unitOrthogonal());
    receivers.triangles.push_back(points.triangles[i]);
    receivers.areas.push_back(1.0F);
    receivers.radii.push_back(1.0F);
  }
  receivers.cluster_begin = {0, static_cast<std::uint32_t>(points.samples.size())};
  return receivers;
}

/// Area means per cluster of what points uniform in area gather from the samples: direct light and
/// `indirect` (samples × channels·lights). One batch with random numbers of its own.
MatrixD gathered_anywhere(const Setting& s, const SenderSearch& search, const MatrixF& indirect,
                          int batch) {
  static const HemisphereDirections directions(kReceiverDirections);
  const auto key = static_cast<std::uint64_t>(batch);
  const CellPoints points =
      draw_cell_points(s.scene, s.bake->caster(), s.samples, search, cumulative_areas(s.scene),
                       kReceiversPerBatch, 0, kReceiversPerBatch, stream_key(key, "receivers"));
  const SampleSet receivers = receivers_at(s, points, stream_key(key, "turns"));
  const HemisphereRays rays =
      cast_hemispheres(s.scene, s.bake->caster(), receivers, search, directions, 0,
                       static_cast<std::uint32_t>(receivers.size()), samples_diagonal(s.samples));
  std::vector<MatrixF> light;
  for (Eigen::Index c = 0; c < kChannels; ++c) {
    light.emplace_back(s.projected + indirect.middleCols(c * kLights, kLights));
  }
  const std::vector<MatrixF> received =
      gather_fields(gather_entries(rays.senders, directions.weights(), s.samples.size()),
                    s.bake->result(kAlbedoTask)->matrix("albedo"), light);
  const auto cluster = s.samples.cluster_of_sample();
  MatrixD means = MatrixD::Zero(s.samples.clusters(), indirect.cols());
  VectorD counts = VectorD::Zero(s.samples.clusters());
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const std::uint32_t own = cluster[points.samples[i]];
    counts[own] += 1.0;
    for (Eigen::Index c = 0; c < kChannels; ++c) {
      means.row(own).segment(c * kLights, kLights) +=
          received[c].row(static_cast<Eigen::Index>(i)).cast<double>();
    }
  }
  return counts.cwiseInverse().asDiagonal() * means;
}

/// Mean of batches and its squared standard error.
class Batches {
 public:
  void add(const MatrixD& batch) {
    if (count_ == 0) sum_ = squares_ = 0.0 * batch;
    sum_ += batch;
    squares_ += batch.cwiseAbs2();
    count_ += 1.0;
  }
  [[nodiscard]] MatrixD mean() const { return sum_ / count_; }
  [[nodiscard]] MatrixD variance() const {
    return (squares_ / count_ - mean().cwiseAbs2()).cwiseMax(0.0) / (count_ - 1.0);
  }

 private:
  MatrixD sum_, squares_;
  double count_ = 0.0;
};

/// Area means, regions × (channels · lights). A region is a cluster or the scene.
struct Comparison {
  MatrixD gather, photons, error;  ///< error: standard error of the difference
  Eigen::RowVectorXd scene_mean;   ///< of photons
};
struct Comparisons {
  Comparison scene, clusters;
};

/// The scene: irradiance at the samples, as the player has it. Clusters: the samples of one are too
/// few to tell its mean to 1 %, so the light at the samples is gathered once more, at as many
/// random points as that needs. Both solvers then have the same expectation but for kBias.
Comparisons compare() {
  const Setting s;
  const SenderSearch search(s.scene, s.samples);
  VectorD share(s.samples.clusters());
  for (std::uint32_t c = 0; c < s.samples.clusters(); ++c) {
    share[c] = cluster_areas(s.samples, c).cast<double>().sum();
  }
  share /= share.sum();
  const MatrixF at_samples = gathered(s);
  Batches anywhere, shots, scene_shots;
  for (int batch = 0; batch < kBatches; ++batch) {
    anywhere.add(gathered_anywhere(s, search, at_samples, batch));
    const MatrixD means = s.cluster_means(shot(s, search, batch));
    shots.add(means);
    scene_shots.add(share.transpose() * means);
  }
  const Eigen::RowVectorXd scene_mean = scene_shots.mean();
  return {{share.transpose() * s.cluster_means(at_samples), scene_mean,
           scene_shots.variance().cwiseSqrt(), scene_mean},
          {anywhere.mean(), shots.mean(), (anywhere.variance() + shots.variance()).cwiseSqrt(),
           scene_mean}};
}

/// Every deviation lies within the bias allowed and the noise.
void expect_agreement(const Comparison& both) {
  const Eigen::Index regions = both.gather.rows();
  const double alpha =
      1.0 - std::pow(1.0 - test::kFamilyWiseError, 1.0 / static_cast<double>(both.gather.size()));
  double largest = 0.0;
  double largest_error = 0.0;
  for (Eigen::Index c = 0; c < regions; ++c) {
    for (Eigen::Index l = 0; l < both.gather.cols(); ++l) {
      const double mean = both.scene_mean[l];
      const double error = both.error(c, l);
      const double off = std::abs(both.gather(c, l) - both.photons(c, l));
      largest = std::max(largest, off / mean);
      largest_error = std::max(largest_error, error / mean);
      const double beyond = std::max(0.0, off - kBias * mean);
      EXPECT_GE(test::p_value(beyond / error), alpha)
          << "region " << c << ", light " << l % static_cast<Eigen::Index>(kLights) << ", channel "
          << l / static_cast<Eigen::Index>(kLights) << ": gather " << both.gather(c, l)
          << ", photons " << both.photons(c, l) << " +- " << error << ", scene's mean " << mean;
    }
  }
  const double typical = std::sqrt(
      (both.error * both.scene_mean.cwiseInverse().transpose().asDiagonal()).cwiseAbs2().mean());
  std::cout << both.gather.size() << " comparisons; of the scene's mean, largest deviation "
            << largest << ", largest standard error " << largest_error << ", typical " << typical
            << '\n';
}

const Comparisons& comparisons() {
  static const Comparisons all = compare();
  return all;
}

TEST(GatherAndPhotons, AgreeOnTheSceneUnderHeldOutLights) { expect_agreement(comparisons().scene); }

TEST(GatherAndPhotons, AgreeOnEveryClusterUnderHeldOutLights) {
  expect_agreement(comparisons().clusters);
}

}  // namespace
}  // namespace prt
