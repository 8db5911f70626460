#include "domains/thinning.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "domains/samples.h"

namespace prt {

namespace {

/// With its operations spelt out, so that no compiler's choice of them changes which points stay.
float length_of(const Vec3f& d) {
  return std::sqrt(std::fma(d.x(), d.x(), std::fma(d.z(), d.z(), d.y() * d.y())));
}

}  // namespace

float triangle_curvature(const Scene& scene, std::uint32_t triangle) {
  const auto& v = scene.triangles[triangle].vertex;
  float curvature = 0.0F;
  for (int k = 0; k < 3; ++k) {
    const auto a = v[k];
    const auto b = v[(k + 1) % 3];
    const float length = length_of(scene.positions[a] - scene.positions[b]);
    const float turn = length_of(scene.normals[a] - scene.normals[b]);
    if (length > 0.0F) curvature = std::max(curvature, turn / length);
  }
  return curvature;
}

float candidate_radius(float radius, float curvature) {
  return std::max(radius / std::fma(curvature, radius, 1.0F), 0.25F * radius);
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
    std::uint32_t name;
  };
  /// Name of a compatible point that lies nearer than the smaller of the two radii, or kNone.
  [[nodiscard]] std::uint32_t conflict(const Vec3f& p, const Vec3f& n, float radius,
                                       float min_cosine) const {
    const auto look = [&](std::size_t slot) {
      for (auto e = head_[slot]; e != kNone; e = points_[e].next) {
        const Point& q = points_[e];
        const float limit = std::min(radius, q.radius);
        if ((q.position - p).squaredNorm() < limit * limit && q.normal.dot(n) >= min_cosine) {
          return q.name;
        }
      }
      return kNone;
    };
    const auto [x, y, z] = cell(p);
    const std::uint32_t beside = look(slot(x, y, z));  // most are found here
    if (beside != kNone) return beside;
    const auto [x0, y0, z0] = cell(p - Vec3f::Constant(radius));
    const auto [x1, y1, z1] = cell(p + Vec3f::Constant(radius));
    for (int k = z0; k <= z1; ++k) {
      for (int j = y0; j <= y1; ++j) {
        for (int i = x0; i <= x1; ++i) {
          const std::uint32_t found = look(slot(i, j, k));
          if (found != kNone) return found;
        }
      }
    }
    return kNone;
  }
  void add(const Vec3f& p, const Vec3f& n, float radius, std::uint32_t name) {
    const auto [x, y, z] = cell(p);
    auto& head = head_[slot(x, y, z)];
    points_.push_back({p, radius, n, head, name});
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

struct Place {
  std::uint64_t priority;
  std::uint32_t index;
};

/// Places by falling priority, equal ones by index. Priorities are random: dealt out by their
/// leading bits, each few are sorted within the caches.
std::vector<Place> sorted_places(std::span<const std::uint64_t> priorities) {
  constexpr int kBits = 12;
  const auto deal = [](std::uint64_t priority) { return ~priority >> (64 - kBits); };
  std::vector<std::size_t> begin((std::size_t{1} << kBits) + 1, 0);
  for (const std::uint64_t p : priorities) ++begin[deal(p) + 1];
  for (std::size_t b = 1; b < begin.size(); ++b) begin[b] += begin[b - 1];
  std::vector<Place> order(priorities.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    order[next[deal(priorities[i])]++] = {priorities[i], i};
  }
  for (std::size_t b = 0; b + 1 < begin.size(); ++b) {
    std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin[b]),
              order.begin() + static_cast<std::ptrdiff_t>(begin[b + 1]),
              [](const Place& a, const Place& c) {
                return a.priority != c.priority ? a.priority > c.priority : a.index < c.index;
              });
  }
  return order;
}

/// The candidates, highest priority first. Copies: thinning goes through them several times, and
/// indices in this order would miss the cache at each.
std::vector<Candidate> by_priority(const Candidates& candidates) {
  std::vector<Candidate> sorted;
  sorted.reserve(candidates.size());
  for (const Place& place : sorted_places(candidates.priorities)) {
    const std::uint32_t i = place.index;
    sorted.push_back({candidates.positions[i], candidates.normals[i], candidates.curvatures[i], i});
  }
  return sorted;
}

/// Thins a pool, at one radius after another. Whom a candidate gave way to is looked at first the
/// next time: mostly that one stays again, and the search around is spared.
class Thinning {
 public:
  /// `pool`: highest priority first; must outlive it. `expected`: about so many stay.
  Thinning(std::span<const Candidate> pool, std::size_t expected, float min_cosine)
      : pool_(pool),
        expected_(std::min(pool.size(), expected)),
        min_cosine_(min_cosine),
        gave_way_to_(pool.size(), kNone) {}

  std::vector<std::uint32_t> at(float radius) {
    std::vector<std::uint32_t> kept;
    std::vector<std::uint8_t> stays(pool_.size(), 0);
    GrowingGrid grid(2 * expected_, radius);
    for (std::uint32_t k = 0; k < pool_.size(); ++k) {
      fetch(k + kAhead);
      const Candidate& c = pool_[k];
      const float r = candidate_radius(radius, c.curvature);
      std::uint32_t& other = gave_way_to_[k];
      if (other != kNone && stays[other] != 0 && is_nearer(c, pool_[other], r, radius)) continue;
      const std::uint32_t found = grid.conflict(c.position, c.normal, r, min_cosine_);
      if (found != kNone) {
        other = found;
        continue;
      }
      grid.add(c.position, c.normal, r, k);
      stays[k] = 1;
      kept.push_back(c.index);
    }
    std::sort(kept.begin(), kept.end());
    return kept;
  }

 private:
  // Candidates between fetching and looking: enough to cover a cache miss.
  static constexpr std::uint32_t kAhead = 16;

  void fetch(std::uint32_t k) const {
    if (k >= pool_.size() || gave_way_to_[k] == kNone) return;
    __builtin_prefetch(pool_.data() + gave_way_to_[k]);
  }
  static bool is_nearer(const Candidate& c, const Candidate& other, float r, float radius) {
    const float limit = std::min(r, candidate_radius(radius, other.curvature));
    return (other.position - c.position).squaredNorm() < limit * limit;
  }

  std::span<const Candidate> pool_;
  std::size_t expected_;
  float min_cosine_;
  std::vector<std::uint32_t> gave_way_to_;  // places in the pool; compatible ones
};

float extent(const Candidates& candidates) {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
  for (const Vec3f& p : candidates.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

/// What is looked for: so many, to a share, at radii of a range alone.
struct Search {
  std::size_t count;
  double tolerance;
  float min_cosine;
  RadiusRange range = {0.0F, kInfinity};
};

/// Finds the radius by secant steps (count ∝ radius^-2) inside a bracket that every try narrows.
/// Nothing where a step leaves the range.
std::optional<ThinnedTo> search(std::span<const Candidate> pool, const Search& wanted,
                                float radius) {
  constexpr int kMostTries = 40;
  float low = 0.0F;
  float high = kInfinity;
  ThinnedTo best{radius, {}};
  double best_off = 1e30;
  Thinning thinning(pool, wanted.count, wanted.min_cosine);
  for (int i = 0; i < kMostTries; ++i) {
    if (!wanted.range.contains(radius)) return std::nullopt;
    auto kept = thinning.at(radius);
    const double off = static_cast<double>(kept.size()) / static_cast<double>(wanted.count) - 1.0;
    if (std::abs(off) < best_off) {
      best_off = std::abs(off);
      best = {radius, std::move(kept)};
    }
    if (best_off <= wanted.tolerance) break;
    (off > 0 ? low : high) = radius;
    float next = radius * static_cast<float>(std::sqrt(std::max(1e-4, 1.0 + off)));
    if (!(next > low && next < high)) next = 0.5F * (low + std::min(high, 2.0F * low + next));
    if (!(next > low && next < high)) break;  // the count jumps here: no radius gives it
    radius = next;
  }
  return best;
}

constexpr double kTolerance = 0.015;
// A sixteenth of candidates and count finds the scale at a sixteenth of the cost.
constexpr std::size_t kPart = 16;
constexpr std::size_t kLeastOfPart = 32;
// How far a guessed radius may be off. A wider range leaves more candidates.
constexpr float kGuessSlack = 0.03F;

/// `highest`: at least the part of all candidates that has the highest priority, in that order.
float first_radius(std::span<const Candidate> highest, std::size_t candidates, float extent,
                   std::size_t count, float min_cosine) {
  float radius = extent / std::sqrt(static_cast<float>(std::max<std::size_t>(1, count)));
  if (!(radius > 0.0F)) radius = 1.0F;
  if (count / kPart < kLeastOfPart) return radius;
  const Search wanted{count / kPart, 0.05, min_cosine};
  return search(highest.first(candidates / kPart), wanted, 4.0F * radius)->radius / 4.0F;
}

/// The radius for `count` of all candidates, from parts of them whose radii are 4 and 8 times as
/// wide everywhere. Edges and small things weigh in proportion to that; it is extrapolated to 1.
float extrapolated_radius(std::span<const Candidate> highest, std::size_t candidates, float first,
                          std::size_t count, float min_cosine) {
  const auto from_part = [&](float scale) {
    const auto part = static_cast<std::size_t>(scale * scale);
    std::vector<Candidate> pool(highest.begin(),
                                highest.begin() + static_cast<std::ptrdiff_t>(candidates / part));
    for (Candidate& c : pool) c.curvature /= scale;
    return search(pool, {count / part, kTolerance, min_cosine}, scale * first)->radius / scale;
  };
  if (count / kPart < kLeastOfPart) return first;
  const float wide = from_part(4.0F);
  if (count / (4 * kPart) < kLeastOfPart) return wide;
  return wide + 0.75F * (wide - from_part(8.0F));
}

}  // namespace

std::vector<std::uint32_t> thin(const Candidates& candidates, float radius, float min_cosine) {
  const auto order = by_priority(candidates);
  return Thinning(order, order.size() / 8, min_cosine).at(radius);
}

ThinnedTo thin_to_count(const Candidates& candidates, std::size_t count, float min_cosine) {
  const auto order = by_priority(candidates);
  const float radius = first_radius(order, order.size(), extent(candidates), count, min_cosine);
  return *search(order, {count, kTolerance, min_cosine}, radius);
}

RadiusGuess guess_radius(const Candidates& highest, std::size_t candidates, float extent,
                         std::size_t count, float min_cosine) {
  if (highest.size() < candidates / kPart) throw std::logic_error("too few candidates of all");
  const std::vector<Candidate> order = by_priority(highest);
  RadiusGuess guess;
  guess.first = first_radius(order, candidates, extent, count, min_cosine);
  const float end = extrapolated_radius(order, candidates, guess.first, count, min_cosine);
  guess.range = {std::min(guess.first, end * (1.0F - kGuessSlack)),
                 std::max(guess.first, end * (1.0F + kGuessSlack))};
  return guess;
}

std::optional<ThinnedTo> thin_to_count(const Candidates& left, const RadiusGuess& guess,
                                       std::size_t count, float min_cosine) {
  return search(by_priority(left), {count, kTolerance, min_cosine, guess.range}, guess.first);
}

std::vector<std::uint32_t> drop_beaten(const Candidates& candidates, std::span<const float> known,
                                       const RadiusRange& range, float min_cosine) {
  // Radii of curved places grow with the radius but for rounding.
  const float slack = range.low < range.high ? 1e-6F : 0.0F;
  const std::vector<Candidate> order = by_priority(candidates);
  GrowingGrid stay(order.size() / 16, range.high);  // at every radius
  GrowingGrid may_stay(order.size() / 4, range.high);
  std::vector<std::uint32_t> left;
  for (const Candidate& c : order) {
    const float low = candidate_radius(range.low, c.curvature) * (1.0F - slack);
    const float high = candidate_radius(range.high, c.curvature) * (1.0F + slack);
    if (stay.conflict(c.position, c.normal, low, min_cosine) != kNone) continue;
    const bool is_highest = known[c.index] >= high &&
                            may_stay.conflict(c.position, c.normal, high, min_cosine) == kNone;
    if (is_highest) stay.add(c.position, c.normal, low, c.index);
    may_stay.add(c.position, c.normal, high, c.index);
    left.push_back(c.index);
  }
  std::sort(left.begin(), left.end());
  return left;
}

}  // namespace prt
