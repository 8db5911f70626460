// Regions and their windows: every cluster once, and no more light lost than is said.
#include "domains/windows.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "unit/domains/random_points.h"

namespace prt {
namespace {

using Lists = std::vector<std::vector<std::uint32_t>>;

ClusterExchange exchange_of(const MatrixD& shares) {
  ClusterExchange exchange;
  exchange.begin = {0};
  for (Eigen::Index r = 0; r < shares.rows(); ++r) {
    for (Eigen::Index s = 0; s < shares.cols(); ++s) {
      if (shares(r, s) == 0.0) continue;
      exchange.senders.push_back(static_cast<std::uint32_t>(s));
      exchange.shares.push_back(static_cast<float>(shares(r, s)));
    }
    exchange.begin.push_back(static_cast<std::uint32_t>(exchange.senders.size()));
  }
  return exchange;
}

/// A corridor of clusters: each sees itself and two neighbours on either side.
MatrixD corridor(Eigen::Index clusters) {
  MatrixD shares = MatrixD::Zero(clusters, clusters);
  const double weight[] = {0.2, 0.25, 0.1};
  for (Eigen::Index r = 0; r < clusters; ++r) {
    for (Eigen::Index s = 0; s < clusters; ++s) {
      if (std::abs(r - s) <= 2) shares(r, s) = weight[std::abs(r - s)];
    }
  }
  return shares;
}

/// Indirect light of every cluster where direct light is 1 on those that are `inside` and there is
/// nothing else.
VectorD indirect(const MatrixD& shares, const VectorD& albedo,
                 const std::vector<std::uint32_t>& inside) {
  MatrixD transport = MatrixD::Zero(shares.rows(), shares.cols());
  VectorD direct = VectorD::Zero(shares.rows());
  for (const std::uint32_t r : inside) {
    direct[r] = 1.0;
    for (const std::uint32_t s : inside) transport(r, s) = shares(r, s) * albedo[s];
  }
  const MatrixD system = MatrixD::Identity(shares.rows(), shares.cols()) - transport;
  return VectorD(system.partialPivLu().solve(direct)) - direct;
}

std::vector<Region> windows_of(const Lists& regions, const ClusterExchange& exchange,
                               const VectorD& albedo, const VectorD& areas,
                               const WindowLimits& limits) {
  return find_windows(regions, exchange, albedo, areas, uniform_irradiance(exchange, albedo),
                      limits);
}

std::vector<std::uint32_t> everything(std::uint32_t count) {
  std::vector<std::uint32_t> all(count);
  for (std::uint32_t c = 0; c < count; ++c) all[c] = c;
  return all;
}

/// Share of a region's indirect light that its window loses.
double lost(const Region& region, const MatrixD& shares, const VectorD& albedo,
            const VectorD& areas) {
  const auto all = everything(static_cast<std::uint32_t>(areas.size()));
  const VectorD whole = indirect(shares, albedo, all);
  const VectorD part = indirect(shares, albedo, region.window);
  double sum = 0.0;
  double total = 0.0;
  for (const std::uint32_t c : region.clusters) {
    sum += areas[c] * (whole[c] - part[c]);
    total += areas[c] * whole[c];
  }
  return sum / total;
}

TEST(Regions, HoldEveryClusterOnceAndAreCompact) {
  const auto centres = test::random_cloud(500, 3).positions;
  const Lists regions = make_regions(centres, 40);
  EXPECT_EQ(regions.size(), 13U);
  std::vector<int> seen(centres.size(), 0);
  for (const auto& region : regions) {
    EXPECT_LE(region.size(), 40U);
    EXPECT_GE(region.size(), 37U);
    EXPECT_TRUE(std::ranges::is_sorted(region));
    for (const auto c : region) ++seen[c];
  }
  EXPECT_EQ(std::ranges::count(seen, 1), std::ssize(seen));
  // Neighbours along a line stay together.
  std::vector<Vec3f> line;
  for (int i = 0; i < 64; ++i) line.emplace_back(0.0F, static_cast<float>(i * 37 % 64), 0.0F);
  for (const auto& region : make_regions(line, 16)) {
    float low = 64.0F;
    float high = 0.0F;
    for (const auto c : region) {
      low = std::min(low, line[c].y());
      high = std::max(high, line[c].y());
    }
    EXPECT_EQ(high - low, 15.0F);
  }
}

TEST(Windows, LoseNoMoreThanTheySay) {
  const MatrixD shares = corridor(60);
  const auto exchange = exchange_of(shares);
  VectorD areas(60);
  VectorD albedo(60);
  for (Eigen::Index c = 0; c < 60; ++c) {
    areas[c] = 1.0 + 0.5 * std::sin(static_cast<double>(c));
    albedo[c] = 0.6 + 0.3 * std::cos(2.0 * static_cast<double>(c));
  }
  const Lists regions = {{0, 1, 2, 3}, {4, 5, 6, 7, 8, 9}, {30, 31, 32}};
  std::size_t last = 0;
  for (const double tolerance : {0.3, 0.1, 0.01, 0.001}) {
    const auto found = windows_of(regions, exchange, albedo, areas, {tolerance, 60});
    ASSERT_EQ(found.size(), regions.size());
    std::size_t size = 0;
    for (std::size_t r = 0; r < found.size(); ++r) {
      const Region& region = found[r];
      EXPECT_EQ(region.clusters, regions[r]);
      EXPECT_TRUE(std::ranges::includes(region.window, region.clusters));
      EXPECT_LE(region.left_out, tolerance);
      const double truly = lost(region, shares, albedo, areas);
      EXPECT_LE(truly, 1.01 * region.left_out);  // the series ends at 1 % of the tolerance
      EXPECT_GE(truly, 0.2 * region.left_out) << "a bound too wide to choose windows by";
      size += region.window.size();
    }
    EXPECT_GT(size, last) << "a tighter tolerance wants larger windows";
    last = size;
  }
}

TEST(Windows, TellWhatALimitOnTheirSizeCosts) {
  const MatrixD shares = corridor(40);
  const VectorD ones = VectorD::Ones(40);
  const auto found =
      windows_of({{18, 19, 20, 21}}, exchange_of(shares), 0.8 * ones, ones, {1e-3, 10});
  EXPECT_EQ(found[0].window.size(), 10U);
  EXPECT_GT(found[0].left_out, 1e-3);
  EXPECT_LE(lost(found[0], shares, 0.8 * ones, ones), 1.01 * found[0].left_out);
}

TEST(Windows, HoldNothingThatSendsNoLight) {
  // Two rooms that do not see each other; a black cluster in the first.
  MatrixD shares = MatrixD::Zero(8, 8);
  shares.topLeftCorner(4, 4).setConstant(0.25);
  shares.bottomRightCorner(4, 4).setConstant(0.25);
  VectorD albedo = VectorD::Constant(8, 0.5);
  albedo[3] = 0.0;
  const auto found = windows_of({{0, 1}, {2, 3}, {4, 5, 6, 7}}, exchange_of(shares), albedo,
                                VectorD::Ones(8), {0.0, 100});
  EXPECT_EQ(found[0].window, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(found[1].window, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(found[2].window, (std::vector<std::uint32_t>{4, 5, 6, 7}));
  for (const Region& region : found) EXPECT_EQ(region.left_out, 0.0);
}

TEST(Windows, EndWhereLightIsNeverLost) {
  const MatrixD shares = MatrixD::Constant(4, 4, 0.25);
  EXPECT_GE(uniform_irradiance(exchange_of(shares), VectorD::Ones(4)).maxCoeff(), 1e4);
  EXPECT_NEAR(uniform_irradiance(exchange_of(shares), 0.99 * VectorD::Ones(4)).maxCoeff(), 100.0,
              0.2);
  const auto found = windows_of({{0}, {1, 2, 3}}, exchange_of(shares), VectorD::Ones(4),
                                VectorD::Ones(4), {0.01, 100});
  EXPECT_EQ(found[0].window.size(), 4U);
  EXPECT_EQ(found[1].window.size(), 4U);
}

}  // namespace
}  // namespace prt
