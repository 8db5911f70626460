#include "domains/clusters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/random.h"
#include "domains/thinning.h"

namespace prt {

namespace {

// How much a turned normal counts as distance: at right angles like twice the root radius. Clusters
// of one orientation need fewer basis functions than clusters around corners.
constexpr float kNormalWeight = 4.0F;

/// Interleaves the bits of three 21-bit coordinates.
std::uint64_t morton(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const auto spread = [](std::uint64_t v) {
    v &= 0x1FFFFF;
    v = (v | v << 32) & 0x1F00000000FFFFULL;
    v = (v | v << 16) & 0x1F0000FF0000FFULL;
    v = (v | v << 8) & 0x100F00F00F00F00FULL;
    v = (v | v << 4) & 0x10C30C30C30C30C3ULL;
    return (v | v << 2) & 0x1249249249249249ULL;
  };
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

std::vector<std::uint64_t> curve_codes(const std::vector<Vec3f>& positions) {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
  for (const Vec3f& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const float side = std::max((high - low).maxCoeff(), std::numeric_limits<float>::min());
  std::vector<std::uint64_t> codes;
  codes.reserve(positions.size());
  for (const Vec3f& p : positions) {
    const Vec3f q = (p - low) * (2097151.0F / side);
    codes.push_back(morton(static_cast<std::uint32_t>(q.x()), static_cast<std::uint32_t>(q.y()),
                           static_cast<std::uint32_t>(q.z())));
  }
  return codes;
}

/// v turned by the smallest rotation that takes unit a to unit b; a and b not opposite.
Vec3f turn(const Vec3f& v, const Vec3f& a, const Vec3f& b) {
  const Vec3f axis = a.cross(b);
  const float cosine = a.dot(b);
  return v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0F + cosine));
}

ThinnedTo choose_roots(const LooseSamples& loose, std::size_t cluster_size) {
  const std::vector<float> flat(loose.positions.size(), 0.0F);
  const Candidates candidates{loose.positions, loose.normals, flat, loose.priorities};
  const std::size_t wanted =
      std::max<std::size_t>(1, (loose.positions.size() + cluster_size / 2) / cluster_size);
  return thin_to_count(candidates, wanted, kCompatibleCosine);
}

/// The compatible root nearest in position and normal, for every sample.
std::vector<std::uint32_t> nearest_roots(const LooseSamples& loose, const ThinnedTo& roots) {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  for (const auto r : roots.kept) {
    positions.push_back(loose.positions[r]);
    normals.push_back(loose.normals[r]);
  }
  const SampleGrid grid(positions, normals, roots.radius);
  std::vector<std::uint32_t> nearest;
  std::vector<std::uint32_t> near;
  for (std::size_t i = 0; i < loose.positions.size(); ++i) {
    near.clear();
    // thin() is maximal: a compatible root lies within the radius, or the sample is one itself.
    grid.within(loose.positions[i], 1.5F * roots.radius, near);
    float best = kInfinity;
    std::uint32_t chosen = kNone;
    for (const auto r : near) {
      const float cosine = loose.normals[i].dot(normals[r]);
      if (cosine < kCompatibleCosine) continue;
      const float squared = (loose.positions[i] - positions[r]).squaredNorm() +
                            kNormalWeight * roots.radius * roots.radius * (1.0F - cosine);
      if (squared < best || (squared == best && r < chosen)) {
        best = squared;
        chosen = r;
      }
    }
    nearest.push_back(chosen);
  }
  return nearest;
}

}  // namespace

ClusteredSamples cluster_samples(const LooseSamples& loose, std::size_t cluster_size) {
  const std::size_t count = loose.positions.size();
  ClusteredSamples result;
  SampleSet& out = result.samples;
  if (count == 0) {
    out.cluster_begin = {0};
    return result;
  }
  const ThinnedTo roots = choose_roots(loose, cluster_size);
  const std::vector<std::uint32_t> cluster = nearest_roots(loose, roots);
  const auto codes = curve_codes(loose.positions);
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(cluster[a], codes[a], a) < std::tie(cluster[b], codes[b], b);
  });
  out.cluster_begin.assign(roots.kept.size() + 1, 0);
  result.roots.assign(roots.kept.size(), kNone);
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t i = order[k];
    const std::uint32_t c = cluster[i];
    out.positions.push_back(loose.positions[i]);
    out.normals.push_back(loose.normals[i]);
    out.radii.push_back(loose.radii[i]);
    out.triangles.push_back(loose.triangles[i]);
    const Vec3f& root_normal = loose.normals[roots.kept[c]];
    const Vec3f root_tangent = frame_from_normal(root_normal).col(0);
    const Vec3f turned = turn(root_tangent, root_normal, loose.normals[i]);
    const Vec3f& n = loose.normals[i];
    out.tangents.push_back((turned - n * n.dot(turned)).normalized());
    ++out.cluster_begin[c + 1];
    if (i == roots.kept[c]) result.roots[c] = k;
  }
  for (std::size_t c = 0; c < roots.kept.size(); ++c)
    out.cluster_begin[c + 1] += out.cluster_begin[c];
  return result;
}

}  // namespace prt
