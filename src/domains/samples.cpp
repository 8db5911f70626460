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
void SampleGrid::visit_cells(const Vec3f& p, float radius, Visit&& visit) const {
  const Vec3f r = Vec3f::Constant(radius);
  const Cell low = cell_of(p - r, inverse_cell_);
  const Cell high = cell_of(p + r, inverse_cell_);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) visit(slot(x, y, z), Cell{x, y, z});
    }
  }
}

namespace {

/// Squared distances along one axis from a coordinate to its own cell and that cell's two
/// neighbours.
struct AxisGaps {
  AxisGaps(float value, int cell_index, float cell) {
    const float below = std::max(0.0F, value - static_cast<float>(cell_index) * cell);
    const float above = std::max(0.0F, static_cast<float>(cell_index + 1) * cell - value);
    // The factor covers the rounding of cell borders; it only costs a look.
    squared = {0.9999F * below * below, 0.0F, 0.9999F * above * above};
  }
  std::array<float, 3> squared;
};

}  // namespace

void SampleGrid::scan(std::size_t s, const Vec3f& p, const Vec3f& n, float min_cosine,
                      Nearest& best) const {
  for (std::uint32_t e = begin_[s]; e < begin_[s + 1]; ++e) {
    const Entry& entry = entries_[e];
    const Vec3f offset = entry.position - p;
    if (offset.squaredNorm() > best.squared_radius) continue;
    const float d = squared_distance_off(offset, n);
    if (d > best.squared_distance || (d == best.squared_distance && entry.index >= best.index)) {
      continue;
    }
    if (entry.normal.dot(n) < min_cosine) continue;
    best.squared_distance = d;
    best.index = entry.index;
  }
}

std::uint32_t SampleGrid::nearest(const Vec3f& p, const Vec3f& n, float radius,
                                  float min_cosine) const {
  if (entries_.empty()) return kNone;
  Nearest best{radius * radius};
  if (radius * inverse_cell_ > 1.0F) {
    // Wider than a cell: rare, so simply every cell of the box.
    visit_cells(p, radius, [&](std::size_t s, const auto&) { scan(s, p, n, min_cosine, best); });
    return best.index;
  }
  // The middle cell first: it mostly holds the answer, and rules its neighbours out by distance.
  const Cell middle = cell_of(p, inverse_cell_);
  scan(slot(middle.x, middle.y, middle.z), p, n, min_cosine, best);
  const float cell = 1.0F / inverse_cell_;
  const AxisGaps gap_x(p.x(), middle.x, cell);
  const AxisGaps gap_y(p.y(), middle.y, cell);
  const AxisGaps gap_z(p.z(), middle.z, cell);
  for (int z = 0; z < 3; ++z) {
    if (gap_z.squared[z] > best.reach()) continue;
    for (int y = 0; y < 3; ++y) {
      const float gap_zy = gap_z.squared[z] + gap_y.squared[y];
      if (gap_zy > best.reach()) continue;
      for (int x = 0; x < 3; ++x) {
        if (gap_zy + gap_x.squared[x] > best.reach() || (x == 1 && y == 1 && z == 1)) {
          continue;
        }
        scan(slot(middle.x + x - 1, middle.y + y - 1, middle.z + z - 1), p, n, min_cosine, best);
      }
    }
  }
  return best.index;
}

template <typename Accept>
void SampleGrid::collect(const Vec3f& p, float radius, std::vector<std::uint32_t>& out,
                         Accept&& accept) const {
  if (entries_.empty()) return;
  const float limit = radius * radius;
  visit_cells(p, radius, [&](std::size_t s, const Cell& cell) {
    for (std::uint32_t e = begin_[s]; e < begin_[s + 1]; ++e) {
      const Entry& entry = entries_[e];
      // Cells share hash slots: count an entry in its own cell only.
      if ((entry.position - p).squaredNorm() > limit || !accept(entry)) continue;
      if (cell_of(entry.position, inverse_cell_) == cell) out.push_back(entry.index);
    }
  });
}

void SampleGrid::within(const Vec3f& p, float radius, std::vector<std::uint32_t>& out) const {
  collect(p, radius, out, [](const Entry&) { return true; });
}

void SampleGrid::within(const Vec3f& p, const Vec3f& n, float radius,
                        std::vector<std::uint32_t>& out) const {
  collect(p, radius, out,
          [&](const Entry& entry) { return entry.normal.dot(n) >= kCompatibleCosine; });
}

}  // namespace prt
