#include "domains/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "domains/thinning.h"
#include "unit/domains/random_points.h"

namespace prt {
namespace {

// A few float roundings of unit vectors.
constexpr float kRounding = 1e-5F;

LooseSamples sphere_samples(std::size_t count, std::uint64_t stream) {
  const test::PointCloud cloud = test::sphere_cloud(16 * count, stream);
  const ThinnedTo thinned =
      thin_to_count({cloud.positions, cloud.normals, cloud.curvatures, cloud.priorities}, count,
                    kCompatibleCosine);
  LooseSamples loose;
  for (const auto i : thinned.kept) {
    loose.positions.push_back(cloud.positions[i]);
    loose.normals.push_back(cloud.normals[i]);
    loose.radii.push_back(thinned.radius * (1.0F + 0.01F * static_cast<float>(i % 7)));
    loose.triangles.push_back(i);
    loose.priorities.push_back(cloud.priorities[i]);
  }
  return loose;
}

TEST(Clusters, PartitionTheSamples) {
  const LooseSamples loose = sphere_samples(3000, 1);
  const ClusteredSamples clustered = cluster_samples(loose, 150);
  const SampleSet& samples = clustered.samples;
  EXPECT_NEAR(static_cast<double>(samples.clusters()), 20.0, 1.5);
  ASSERT_EQ(samples.cluster_begin.front(), 0U);
  ASSERT_EQ(samples.cluster_begin.back(), samples.size());
  for (std::size_t c = 0; c < samples.clusters(); ++c) ASSERT_GT(samples.cluster_size(c), 0U);
  const auto cluster = samples.cluster_of_sample();
  ASSERT_TRUE(std::is_sorted(cluster.begin(), cluster.end()));
  // Every loose sample is there once, with all that belongs to it.
  ASSERT_EQ(samples.size(), loose.positions.size());
  std::map<std::uint32_t, std::size_t> place;  // triangles are unique here
  for (std::size_t i = 0; i < loose.triangles.size(); ++i) place[loose.triangles[i]] = i;
  std::set<std::size_t> seen;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const std::size_t i = place.at(samples.triangles[s]);
    EXPECT_TRUE(seen.insert(i).second);
    EXPECT_EQ(samples.positions[s], loose.positions[i]);
    EXPECT_EQ(samples.normals[s], loose.normals[i]);
    EXPECT_EQ(samples.radii[s], loose.radii[i]);
  }
}

TEST(Clusters, EverySampleIsCompatibleWithItsRoot) {
  const ClusteredSamples clustered = cluster_samples(sphere_samples(3000, 2), 150);
  const SampleSet& samples = clustered.samples;
  const auto cluster = samples.cluster_of_sample();
  ASSERT_EQ(clustered.roots.size(), samples.clusters());
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const std::uint32_t root = clustered.roots[cluster[s]];
    ASSERT_EQ(cluster[root], cluster[s]);
    EXPECT_GE(samples.normals[s].dot(samples.normals[root]), kCompatibleCosine);
  }
}

TEST(Clusters, ASampleHasTheNearestRootOnAPlane) {
  // All normals alike: the distance in position alone decides.
  LooseSamples loose;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    Random random(3, i);
    const float x = random.uniform();
    loose.positions.emplace_back(x, 0.0F, random.uniform());
    loose.normals.push_back(Vec3f::UnitY());
    loose.radii.push_back(0.01F);
    loose.triangles.push_back(i);
    const std::uint64_t high = random.bits();
    loose.priorities.push_back(high << 32 | random.bits());
  }
  const ClusteredSamples clustered = cluster_samples(loose, 100);
  const SampleSet& samples = clustered.samples;
  const auto cluster = samples.cluster_of_sample();
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const auto distance = [&](std::uint32_t root) {
      return (samples.positions[root] - samples.positions[s]).squaredNorm();
    };
    const float own = distance(clustered.roots[cluster[s]]);
    for (const auto root : clustered.roots) EXPECT_LE(own, distance(root));
  }
}

TEST(Clusters, FramesAreOrthonormalAndRightHanded) {
  const SampleSet samples = cluster_samples(sphere_samples(3000, 4), 150).samples;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Mat3f frame = samples.frame(s);
    EXPECT_LT((frame.transpose() * frame - Mat3f::Identity()).cwiseAbs().maxCoeff(), kRounding);
    EXPECT_NEAR(frame.determinant(), 1.0F, kRounding);
    EXPECT_EQ(Vec3f(frame.col(2)), samples.normals[s]);
  }
}

TEST(Clusters, TangentsTurnNoFasterThanNormals) {
  const SampleSet samples = cluster_samples(sphere_samples(3000, 5), 150).samples;
  // Two tangents carried from one root over angles α, β differ by the turn of the normals and, at
  // second order, by the enclosed solid angle; within 60° of the root that at most doubles it.
  constexpr float kMostRatio = 2.0F;
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    for (auto a = samples.cluster_begin[c]; a < samples.cluster_begin[c + 1]; ++a) {
      for (auto b = a + 1; b < samples.cluster_begin[c + 1]; ++b) {
        const float turn = (samples.normals[a] - samples.normals[b]).norm();
        ASSERT_LE((samples.tangents[a] - samples.tangents[b]).norm(),
                  kMostRatio * turn + kRounding);
      }
    }
  }
}

TEST(Clusters, OneSampleAndFewerThanAClusterMakeOne) {
  for (const std::size_t count : {1UL, 30UL}) {
    LooseSamples loose;
    for (std::uint32_t i = 0; i < count; ++i) {
      loose.positions.emplace_back(static_cast<float>(i), 0.0F, 0.0F);
      loose.normals.push_back(Vec3f::UnitY());
      loose.radii.push_back(1.0F);
      loose.triangles.push_back(0);
      loose.priorities.push_back(i);
    }
    const ClusteredSamples clustered = cluster_samples(loose, 1000);
    EXPECT_EQ(clustered.samples.clusters(), 1U);
    EXPECT_EQ(clustered.samples.size(), count);
  }
}

}  // namespace
}  // namespace prt
