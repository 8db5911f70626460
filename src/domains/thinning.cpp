#include "domains/thinning.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "domains/samples.h"

namespace prt {

float candidate_radius(float radius, float curvature) {
  return std::max(radius / (1.0F + curvature * radius), 0.25F * radius);
}

namespace {

/// Grid to which points are added one by one; linked lists in hashed cells.
class GrowingGrid {
 public:
  GrowingGrid(std::size_t capacity, float cell) : inverse_cell_(1.0F / cell) {
    const std::size_t slots = std::bit_ceil(std::max<std::size_t>(64, 2 * capacity));
    head_.assign(slots, kNone);
  }
  struct Point {
    Vec3f position;
    float radius;
    Vec3f normal;
    std::uint32_t next;
  };
  /// True if a compatible point lies nearer than the smaller of the two radii.
  [[nodiscard]] bool conflicts(const Vec3f& p, const Vec3f& n, float radius,
                               float min_cosine) const {
    const auto [x0, y0, z0] = cell(p - Vec3f::Constant(radius));
    const auto [x1, y1, z1] = cell(p + Vec3f::Constant(radius));
    for (int z = z0; z <= z1; ++z) {
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          for (auto e = head_[slot(x, y, z)]; e != kNone; e = points_[e].next) {
            const Point& q = points_[e];
            const float limit = std::min(radius, q.radius);
            if ((q.position - p).squaredNorm() < limit * limit && q.normal.dot(n) >= min_cosine) {
              return true;
            }
          }
        }
      }
    }
    return false;
  }
  void add(const Vec3f& p, const Vec3f& n, float radius) {
    const auto [x, y, z] = cell(p);
    auto& head = head_[slot(x, y, z)];
    points_.push_back({p, radius, n, head});
    head = static_cast<std::uint32_t>(points_.size() - 1);
  }

 private:
  struct Cell {
    int x, y, z;
  };
  [[nodiscard]] Cell cell(const Vec3f& p) const {
    const auto at = [this](float v) {
      return static_cast<int>(std::floor(std::clamp(v * inverse_cell_, -1e9F, 1e9F)));
    };
    return {at(p.x()), at(p.y()), at(p.z())};
  }
  [[nodiscard]] std::size_t slot(int x, int y, int z) const {
    const std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
                            static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
                            static_cast<std::uint32_t>(z) * 0xC2B2AE3DU;
    return (h ^ (h >> 15)) & (head_.size() - 1);
  }
  std::vector<std::uint32_t> head_;
  std::vector<Point> points_;
  float inverse_cell_;
};

struct Candidate {
  Vec3f position, normal;
  float curvature;
  std::uint32_t index;  ///< in Candidates
};

/// The candidates, highest priority first. Copies: thinning goes through them several times, and
/// indices in this order would miss the cache at each.
std::vector<Candidate> by_priority(const Candidates& candidates) {
  struct Place {
    std::uint64_t priority;
    std::uint32_t index;
  };
  std::vector<Place> order(candidates.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = {candidates.priorities[i], i};
  std::sort(order.begin(), order.end(), [](const Place& a, const Place& b) {
    return a.priority != b.priority ? a.priority > b.priority : a.index < b.index;
  });
  std::vector<Candidate> sorted;
  sorted.reserve(order.size());
  for (const Place& place : order) {
    const std::uint32_t i = place.index;
    sorted.push_back({candidates.positions[i], candidates.normals[i], candidates.curvatures[i], i});
  }
  return sorted;
}

std::vector<std::uint32_t> thin_in_order(std::span<const Candidate> pool, float radius,
                                         float min_cosine) {
  std::vector<std::uint32_t> kept;
  GrowingGrid grid(pool.size() / 16, radius);
  for (const Candidate& c : pool) {
    const float r = candidate_radius(radius, c.curvature);
    if (grid.conflicts(c.position, c.normal, r, min_cosine)) continue;
    grid.add(c.position, c.normal, r);
    kept.push_back(c.index);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

float extent(const Candidates& candidates) {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
  for (const Vec3f& p : candidates.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

}  // namespace

std::vector<std::uint32_t> thin(const Candidates& candidates, float radius, float min_cosine) {
  return thin_in_order(by_priority(candidates), radius, min_cosine);
}

ThinnedTo thin_to_count(const Candidates& candidates, std::size_t count, float min_cosine) {
  constexpr double kTolerance = 0.015;
  constexpr int kMostTries = 40;
  const auto order = by_priority(candidates);
  const auto off = [](std::size_t have, std::size_t want) {
    return static_cast<double>(have) / static_cast<double>(want) - 1.0;
  };
  // Finds the radius by secant steps (count ∝ radius^-2) inside a bracket that every try narrows.
  const auto search = [&](std::span<const Candidate> pool, std::size_t want, float radius,
                          double tolerance) {
    float low = 0.0F;
    float high = kInfinity;
    ThinnedTo best{radius, {}};
    double best_off = 1e30;
    for (int i = 0; i < kMostTries; ++i) {
      auto kept = thin_in_order(pool, radius, min_cosine);
      const double o = off(kept.size(), want);
      if (std::abs(o) < best_off) {
        best_off = std::abs(o);
        best = {radius, std::move(kept)};
      }
      if (best_off <= tolerance) break;
      (o > 0 ? low : high) = radius;
      float next = radius * static_cast<float>(std::sqrt(std::max(1e-4, 1.0 + o)));
      if (!(next > low && next < high)) next = 0.5F * (low + std::min(high, 2.0F * low + next));
      if (!(next > low && next < high)) break;  // the count jumps here: no radius gives it
      radius = next;
    }
    return best;
  };
  // A sixteenth of both finds the scale at a sixteenth of the cost.
  const std::size_t part = order.size() / 16;
  float radius =
      extent(candidates) / std::sqrt(static_cast<float>(std::max<std::size_t>(1, count)));
  if (!(radius > 0.0F)) radius = 1.0F;
  if (count / 16 >= 32) {
    const std::span<const Candidate> pool(order.data(), part);
    radius = search(pool, count / 16, 4.0F * radius, 0.05).radius / 4.0F;
  }
  return search(order, count, radius, kTolerance);
}

}  // namespace prt
