#include "domains/windows.h"

#include <algorithm>
#include <numeric>

namespace prt {

namespace {

constexpr int kMostBounces = 200;
// Uniformly lit clusters are summed up until a bounce adds no more than this to the brightest.
constexpr double kLeastChange = 1e-5;
// The series ends where what it adds is this share of the tolerance, and parts of it below the
// second number are dropped on the way: so small beside the tolerance that sums of thousands of
// them do not matter.
constexpr double kSeriesShare = 1e-2;
constexpr double kDropShare = 1e-6;

using Clusters = std::vector<std::uint32_t>;

/// Splits along the longest side, into shares of as equal parts as there will be.
void split(std::span<const Vec3f> centres, std::span<std::uint32_t> clusters, std::size_t parts,
           std::vector<Clusters>& regions) {
  if (parts <= 1) {
    regions.emplace_back(clusters.begin(), clusters.end());
    std::ranges::sort(regions.back());
    return;
  }
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
  for (const std::uint32_t c : clusters) {
    low = low.cwiseMin(centres[c]);
    high = high.cwiseMax(centres[c]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::ranges::sort(clusters, [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(centres[a][axis], a) < std::pair(centres[b][axis], b);
  });
  const std::size_t half = parts / 2;
  const std::size_t middle = clusters.size() * half / parts;
  split(centres, clusters.first(middle), half, regions);
  split(centres, clusters.subspan(middle), parts - half, regions);
}

}  // namespace

VectorD uniform_irradiance(const ClusterExchange& exchange, const VectorD& albedo) {
  VectorD lit = VectorD::Ones(albedo.size());
  while (lit.maxCoeff() < kMostGain) {
    VectorD next = VectorD::Ones(albedo.size());
    for (Eigen::Index r = 0; r < albedo.size(); ++r) {
      for (std::uint32_t k = exchange.begin[r]; k < exchange.begin[r + 1]; ++k) {
        const std::uint32_t s = exchange.senders[k];
        next[r] += exchange.shares[k] * albedo[s] * lit[s];
      }
    }
    const double change = (next - lit).cwiseAbs().maxCoeff();
    lit = next;
    if (change <= kLeastChange * lit.maxCoeff()) break;
  }
  return lit;
}

namespace {

/// Sums over bounces of how much of the light that a region gets was at each cluster.
class Visits {
 public:
  Visits(const ClusterExchange& exchange, const VectorD& albedo)
      : exchange_(exchange), albedo_(albedo), sum_(VectorD::Zero(albedo.size())), now_(sum_) {}

  /// Valid until the next call.
  const VectorD& of(const Clusters& region, const VectorD& areas, const VectorD& lit,
                    double tolerance) {
    sum_.setZero();
    now_.setZero();
    at_ = region;
    double start = 0.0;
    for (const std::uint32_t c : region) start += now_[c] = areas[c];
    double all = 0.0;
    for (int bounce = 0; bounce < kMostBounces; ++bounce) {
      step(kDropShare * tolerance * start);
      double added = 0.0;
      for (const std::uint32_t s : at_) {
        sum_[s] += now_[s];
        added += now_[s] * lit[s];
        all += now_[s];
      }
      if (added <= kSeriesShare * tolerance * all) break;
    }
    return sum_;
  }

 private:
  void step(double least) {
    VectorD& next = next_;
    next = VectorD::Zero(now_.size());
    Clusters reached;
    for (const std::uint32_t r : at_) {
      if (now_[r] < least) continue;
      for (std::uint32_t k = exchange_.begin[r]; k < exchange_.begin[r + 1]; ++k) {
        const std::uint32_t s = exchange_.senders[k];
        const double more = now_[r] * exchange_.shares[k] * albedo_[s];
        if (more > 0.0 && next[s] == 0.0) reached.push_back(s);
        next[s] += more;
      }
    }
    std::swap(now_, next_);
    at_ = std::move(reached);
  }

  const ClusterExchange& exchange_;
  const VectorD& albedo_;
  VectorD sum_, now_, next_;
  Clusters at_;  // where now_ is not 0
};

}  // namespace

std::vector<Vec3f> cluster_centres(std::span<const Vec3f> positions,
                                   std::span<const std::uint32_t> cluster_begin) {
  std::vector<Vec3f> centres;
  for (std::size_t c = 0; c + 1 < cluster_begin.size(); ++c) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::uint32_t s = cluster_begin[c]; s < cluster_begin[c + 1]; ++s) {
      sum += positions[s].cast<double>();
    }
    centres.emplace_back((sum / (cluster_begin[c + 1] - cluster_begin[c])).cast<float>());
  }
  return centres;
}

std::vector<std::vector<std::uint32_t>> make_regions(std::span<const Vec3f> centres,
                                                     std::size_t most) {
  std::vector<Clusters> regions;
  Clusters all(centres.size());
  std::iota(all.begin(), all.end(), 0U);
  most = std::max<std::size_t>(1, most);
  split(centres, all, (all.size() + most - 1) / most, regions);
  return regions;
}

std::vector<Region> find_windows(const std::vector<std::vector<std::uint32_t>>& regions,
                                 const ClusterExchange& exchange, const VectorD& albedo,
                                 const VectorD& areas, const VectorD& lit,
                                 const WindowLimits& limits) {
  Visits visits(exchange, albedo);
  std::vector<Region> found;
  for (const Clusters& own : regions) {
    const VectorD& passed = visits.of(own, areas, lit, limits.tolerance);
    const double received = passed.sum();
    std::vector<bool> inside(static_cast<std::size_t>(albedo.size()), false);
    for (const std::uint32_t c : own) inside[c] = true;
    Clusters others;
    double rest = 0.0;
    for (std::uint32_t s = 0; s < inside.size(); ++s) {
      if (inside[s] || passed[s] == 0.0) continue;
      others.push_back(s);
      rest += passed[s] * lit[s];
    }
    std::ranges::stable_sort(others, [&](std::uint32_t a, std::uint32_t b) {
      return passed[a] * lit[a] > passed[b] * lit[b];
    });
    Region region{own, own, 0.0};
    std::size_t taken = 0;
    while (taken < others.size() && rest > limits.tolerance * received &&
           region.window.size() < limits.most_clusters) {
      rest -= passed[others[taken]] * lit[others[taken]];
      region.window.push_back(others[taken++]);
    }
    std::ranges::sort(region.window);
    region.left_out =
        taken < others.size() && received > 0.0 ? std::max(0.0, rest) / received : 0.0;
    found.push_back(std::move(region));
  }
  return found;
}

}  // namespace prt
