#include "domains/samples.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace prt {

std::vector<std::uint32_t> SampleSet::cluster_of_sample() const {
  std::vector<std::uint32_t> cluster(size());
  for (std::uint32_t c = 0; c < clusters(); ++c) {
    std::fill(cluster.begin() + cluster_begin[c], cluster.begin() + cluster_begin[c + 1], c);
  }
  return cluster;
}

Mat3f SampleSet::frame(std::size_t i) const {
  Mat3f frame;
  frame.col(0) = tangents[i];
  frame.col(1) = normals[i].cross(tangents[i]);
  frame.col(2) = normals[i];
  return frame;
}

namespace {

struct Cell {
  int x, y, z;
  friend bool operator==(const Cell&, const Cell&) = default;
};

// Cells beyond this are clamped together: correct, only slower, and no integer overflows.
constexpr float kCellLimit = 1e9F;

int cell_coordinate(float value, float inverse_cell) {
  return static_cast<int>(std::floor(std::clamp(value * inverse_cell, -kCellLimit, kCellLimit)));
}

Cell cell_of(const Vec3f& p, float inverse_cell) {
  return {cell_coordinate(p.x(), inverse_cell), cell_coordinate(p.y(), inverse_cell),
          cell_coordinate(p.z(), inverse_cell)};
}

}  // namespace

std::size_t SampleGrid::slot(int x, int y, int z) const {
  const std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
                          static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
                          static_cast<std::uint32_t>(z) * 0xC2B2AE3DU;
  return (h ^ (h >> 15)) & slot_mask_;
}

SampleGrid::SampleGrid(std::span<const Vec3f> positions, std::span<const Vec3f> normals, float cell)
    : inverse_cell_(1.0F / cell) {
  const std::size_t slots = std::bit_ceil(std::max<std::size_t>(16, positions.size()));
  slot_mask_ = static_cast<std::uint32_t>(slots - 1);
  begin_.assign(slots + 1, 0);
  std::vector<std::uint32_t> slot_of(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Cell c = cell_of(positions[i], inverse_cell_);
    slot_of[i] = static_cast<std::uint32_t>(slot(c.x, c.y, c.z));
    ++begin_[slot_of[i] + 1];
  }
  for (std::size_t s = 0; s < slots; ++s) begin_[s + 1] += begin_[s];
  entries_.resize(positions.size());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    entries_[next[slot_of[i]]++] = {positions[i], i, normals[i]};
  }
}

template <typename Visit>
void SampleGrid::visit(const Vec3f& p, float radius, Visit&& visit) const {
  if (entries_.empty()) return;
  const Vec3f r = Vec3f::Constant(radius);
  const Cell low = cell_of(p - r, inverse_cell_);
  const Cell high = cell_of(p + r, inverse_cell_);
  const auto in_cell = [&](const Cell& c) {
    const std::size_t s = slot(c.x, c.y, c.z);
    for (std::uint32_t e = begin_[s]; e < begin_[s + 1]; ++e) visit(entries_[e], c);
  };
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) in_cell({x, y, z});
    }
  }
}

std::uint32_t SampleGrid::nearest(const Vec3f& p, const Vec3f& n, float radius,
                                  float min_cosine) const {
  if (entries_.empty()) return kNone;
  const float cell = 1.0F / inverse_cell_;
  float best_distance = radius * radius;
  std::uint32_t best = kNone;
  const auto scan = [&](const Cell& c) {
    const std::size_t s = slot(c.x, c.y, c.z);
    for (std::uint32_t e = begin_[s]; e < begin_[s + 1]; ++e) {
      const Entry& entry = entries_[e];
      const float d = (entry.position - p).squaredNorm();
      if (d > best_distance || (d == best_distance && entry.index >= best)) continue;
      if (entry.normal.dot(n) < min_cosine) continue;
      best_distance = d;
      best = entry.index;
    }
  };
  // The middle cell first: it mostly holds the answer, and rules the others out by distance.
  const Cell middle = cell_of(p, inverse_cell_);
  scan(middle);
  const Vec3f r = Vec3f::Constant(radius);
  const Cell low = cell_of(p - r, inverse_cell_);
  const Cell high = cell_of(p + r, inverse_cell_);
  const auto gap = [cell](float value, int c) {  // distance along one axis from value to cell c
    const float below = static_cast<float>(c) * cell - value;
    const float above = value - static_cast<float>(c + 1) * cell;
    const float d = std::max({0.0F, below, above});
    return d * d;
  };
  for (int z = low.z; z <= high.z; ++z) {
    const float gap_z = gap(p.z(), z);
    if (gap_z > best_distance) continue;
    for (int y = low.y; y <= high.y; ++y) {
      const float gap_yz = gap_z + gap(p.y(), y);
      if (gap_yz > best_distance) continue;
      for (int x = low.x; x <= high.x; ++x) {
        const Cell c{x, y, z};
        // The tolerance covers the rounding of cell borders; it only costs a look.
        if (c == middle || (gap_yz + gap(p.x(), x)) * 0.9999F > best_distance) continue;
        scan(c);
      }
    }
  }
  return best;
}

void SampleGrid::within(const Vec3f& p, float radius, std::vector<std::uint32_t>& out) const {
  const float limit = radius * radius;
  visit(p, radius, [&](const Entry& entry, const Cell& cell) {
    // Cells share hash slots: count an entry in its own cell only.
    if (!(cell_of(entry.position, inverse_cell_) == cell)) return;
    if ((entry.position - p).squaredNorm() <= limit) out.push_back(entry.index);
  });
}

}  // namespace prt
