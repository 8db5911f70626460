#include "transport/gather.h"

#include <gtest/gtest.h>

#include "support/random_matrix.h"
#include "transport/hemisphere.h"
#include "transport/near_series.h"

namespace prt {
namespace {

constexpr Eigen::Index kSamples = 50;
constexpr Eigen::Index kReceivers = 20;
constexpr Eigen::Index kDirections = 70;
// Sums of 70 products of floats up to 1.
constexpr float kFloat = 1e-5F;

struct RandomRays {
  explicit RandomRays(Eigen::Index receivers = kReceivers) {
    for (Eigen::Index r = 0; r < receivers; ++r) {
      Random random(1, static_cast<std::uint64_t>(r));
      for (Eigen::Index d = 0; d < kDirections; ++d) {
        const std::uint32_t j = random.below(kSamples + 10);
        senders.push_back(j < kSamples ? j : (j % 2 ? kEscapedSender : kLostSender));
      }
    }
    for (std::uint64_t d = 0; d < kDirections; ++d) weights.push_back(Random(2, d).uniform());
  }
  /// The one-bounce operator of a channel as a dense matrix.
  [[nodiscard]] MatrixF dense(const MatrixF& albedo, Eigen::Index channel) const {
    MatrixF t = MatrixF::Zero(kReceivers, kSamples);
    for (Eigen::Index r = 0; r < kReceivers; ++r) {
      for (Eigen::Index d = 0; d < kDirections; ++d) {
        const std::uint32_t j = senders[static_cast<std::size_t>(r * kDirections + d)];
        if (j < kSamples) t(r, j) += weights[static_cast<std::size_t>(d)] * albedo(j, channel);
      }
    }
    return t;
  }
  std::vector<std::uint32_t> senders;
  std::vector<float> weights;
};

MatrixF random_albedo(Eigen::Index channels) {
  return test::random_matrix(kSamples, channels, 3).cwiseAbs().cast<float>();
}

TEST(Gather, OfFunctionsIsTheDenseProduct) {
  const RandomRays rays;
  // Clusters of uneven size with uneven numbers of functions.
  const std::vector<std::uint32_t> cluster_begin{0, 7, 30, 50};
  ClusterFunctions functions;
  functions.begin = {0, 3, 4, 13};
  functions.values = MatrixF::Zero(kSamples, 9);
  MatrixF all = MatrixF::Zero(kSamples, functions.count());
  std::vector<std::uint32_t> cluster_of_sample(kSamples);
  const MatrixF values = test::random_matrix(kSamples, 9, 4).cast<float>();
  for (std::uint32_t c = 0; c < 3; ++c) {
    for (auto s = cluster_begin[c]; s < cluster_begin[c + 1]; ++s) {
      cluster_of_sample[s] = c;
      functions.values.row(s).head(functions.of(c)) = values.row(s).head(functions.of(c));
      all.row(s).segment(functions.begin[c], functions.of(c)) = values.row(s).head(functions.of(c));
    }
  }
  for (const Eigen::Index channels : {1, 3}) {
    const MatrixF albedo = random_albedo(channels);
    const auto result =
        gather_functions(rays.senders, rays.weights, albedo, functions, cluster_of_sample);
    ASSERT_EQ(result.size(), static_cast<std::size_t>(channels));
    for (Eigen::Index c = 0; c < channels; ++c) {
      const MatrixF expected = rays.dense(albedo, c) * all;
      EXPECT_LT((result[c] - expected).cwiseAbs().maxCoeff(), kFloat);
      EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.1F);
    }
  }
}

TEST(Gather, OfFieldsIsTheDenseProduct) {
  const RandomRays rays;
  for (const Eigen::Index channels : {1, 3}) {
    const MatrixF albedo = random_albedo(channels);
    std::vector<MatrixF> fields;
    for (Eigen::Index c = 0; c < channels; ++c) {
      fields.emplace_back(test::random_matrix(kSamples, 11, 5 + c).cast<float>());
    }
    const auto result =
        gather_fields(gather_entries(rays.senders, rays.weights, kSamples), albedo, fields);
    for (Eigen::Index c = 0; c < channels; ++c) {
      EXPECT_LT((result[c] - rays.dense(albedo, c) * fields[c]).cwiseAbs().maxCoeff(), kFloat);
    }
  }
}

TEST(Gather, OfRowsIsTheDenseProductWithoutThoseThatAreNotThere) {
  const RandomRays rays;
  const MatrixF values = test::random_matrix(kSamples, 2 * kGatherLane, 6).cast<float>();
  MatrixF there = values;
  std::vector<const float*> rows(kSamples);
  for (std::size_t s = 0; s < rows.size(); ++s) {
    rows[s] = values.row(static_cast<Eigen::Index>(s)).data();
    if (s % 7 != 3) continue;
    rows[s] = nullptr;
    there.row(static_cast<Eigen::Index>(s)).setZero();
  }
  const MatrixF result = gather_rows(rays.senders, rays.weights, rows, values.cols());
  const MatrixF expected = rays.dense(MatrixF::Ones(kSamples, 1), 0) * there;
  EXPECT_LT((result - expected).cwiseAbs().maxCoeff(), kFloat);
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.1F);
}

// What near transfer takes entry by entry, the transfer must leave out: once and no more.
TEST(NearSeries, IsTheSumOfPowersAndLeavesTheRest) {
  const RandomRays some(kSamples);
  const float limit = 0.8F;  // about half of the entries lie on each side
  const GatherEntries near = gather_entries(some.senders, some.weights, kSamples, limit);
  EXPECT_GT(near.senders.size(), 100U);
  EXPECT_LT(near.senders.size(),
            gather_entries(some.senders, some.weights, kSamples).senders.size());
  for (const float share : near.shares) EXPECT_GT(share, limit);
  ClusterFunctions unit;  // one function per sample: what is left is the matrix itself
  unit.begin = {0, kSamples};
  unit.values = MatrixF::Identity(kSamples, kSamples);
  const std::vector<std::uint32_t> one_cluster(kSamples, 0);
  const MatrixF albedo = 0.1F * random_albedo(3);
  constexpr std::uint32_t kFirst = 10;
  constexpr std::uint32_t kEnd = 37;
  for (const int bounces : {1, 2, 3}) {
    const NearSeries series = near_series(near, albedo, kFirst, kEnd, bounces);
    std::vector<MatrixF> rest(3, MatrixF::Zero(kEnd - kFirst, kSamples));
    subtract_series(series, unit, one_cluster, rest);
    for (Eigen::Index c = 0; c < 3; ++c) {
      MatrixF n = MatrixF::Zero(kSamples, kSamples);
      for (Eigen::Index r = 0; r < kSamples; ++r) {
        for (std::uint32_t k = near.begin[r]; k < near.begin[r + 1]; ++k) {
          n(r, near.senders[k]) = near.shares[k] * albedo(near.senders[k], c);
        }
      }
      MatrixF sum = n;
      for (int bounce = 1; bounce < bounces; ++bounce) sum = n + n * sum;
      const MatrixF expected = sum.middleRows(kFirst, kEnd - kFirst);
      EXPECT_LT((rest[c] + expected).cwiseAbs().maxCoeff(), kFloat * expected.maxCoeff());
      EXPECT_GT(expected.maxCoeff(), 0.1F);
    }
  }
}

}  // namespace
}  // namespace prt
