#include "player/gl/splat_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace prt::gl {
namespace {

/// Cells are numbered in 21 bits an axis.
constexpr float kLimit = 1 << 20;
constexpr std::uint32_t kAxis = 0x1FFFFF;
/// Side of a cell in median radii of the kernels: smaller, and there are more cells than are worth
/// their memory; larger, and lists grow longer than what reaches a pixel.
constexpr float kCellRadii = 1.0F;
/// Where a kernel ends that is not weak (kWeakKernel in shaders/splats.glsl), in radii: from its
/// sample, and across its tangent plane. It is at most 1.52 along and 0.32 across the plane between
/// two tangent planes, which is at most 30° off the sample's.
constexpr float kReach = 1.6F;
constexpr float kReachAcross = 1.1F;
constexpr std::uint32_t kEmpty = 0xFFFFFFFFU;

struct Slot {
  std::uint64_t key = 0;         // two words on the GL, the lower one first
  std::uint32_t begin = kEmpty;  // count, while counting
  std::uint32_t end = 0;
};

/// Open addressing; doubles when it is half full.
class Table {
 public:
  Table() : slots_(1024) {}

  Slot& at(const Cell& cell) {
    if (2 * used_ > slots_.size()) grow();
    Slot& slot = find(key_of(cell));
    if (slot.begin == kEmpty) {
      ++used_;
      slot.key = key_of(cell);
      slot.begin = 0;
    }
    return slot;
  }
  [[nodiscard]] std::vector<Slot>& slots() { return slots_; }

 private:
  static std::uint64_t key_of(const Cell& cell) {
    const auto part = [](int coordinate) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(coordinate) & kAxis);
    };
    return part(cell.x()) | part(cell.y()) << 21 | part(cell.z()) << 42;
  }
  Slot& find(std::uint64_t key) {
    const auto x = static_cast<std::uint32_t>(key) & kAxis;
    const auto y = static_cast<std::uint32_t>(key >> 21) & kAxis;
    const auto z = static_cast<std::uint32_t>(key >> 42) & kAxis;
    const std::uint32_t hash = x * 0x9E3779B1U ^ y * 0x85EBCA77U ^ z * 0xC2B2AE3DU;
    std::size_t slot = (hash ^ (hash >> 15)) & (slots_.size() - 1);
    while (slots_[slot].begin != kEmpty && slots_[slot].key != key) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    return slots_[slot];
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.begin != kEmpty) find(slot.key) = slot;
    }
  }

  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

}  // namespace

Cell cell_of(const Vec3f& p, float inverse_cell) {
  const auto coordinate = [&](float value) {
    return static_cast<int>(std::floor(std::clamp(value * inverse_cell, -kLimit, kLimit - 1.0F)));
  };
  return {coordinate(p.x()), coordinate(p.y()), coordinate(p.z())};
}

CellLists::CellLists(std::size_t samples, float cell,
                     const std::function<void(std::uint32_t, const Add&)>& visit)
    : inverse_cell_(1.0F / cell) {
  Table table;
  for (std::uint32_t i = 0; i < samples; ++i) {
    visit(i, [&](const Cell& c) { ++table.at(c).begin; });
  }
  std::uint32_t quads = 0;
  for (Slot& slot : table.slots()) {
    if (slot.begin == kEmpty) continue;
    const std::uint32_t length = (slot.begin + 3) / 4;
    slot.begin = 4 * quads;
    slot.end = slot.begin;
    quads += length;
  }
  // What pads a list is the entry behind the last sample, which reaches nothing.
  std::vector<std::uint32_t> lists(std::size_t{4} * quads, static_cast<std::uint32_t>(samples));
  for (std::uint32_t i = 0; i < samples; ++i) {
    visit(i, [&](const Cell& c) { lists[table.at(c).end++] = i; });
  }
  for (Slot& slot : table.slots()) {
    if (slot.begin == kEmpty) continue;
    slot.begin /= 4;
    slot.end = (slot.end + 3) / 4;
  }
  slot_mask_ = static_cast<std::uint32_t>(table.slots().size() - 1);
  table_ = texels(GL_RGBA32UI, 16, table.slots());
  lists_ = texels(GL_RGBA32UI, 16, lists);
}

void CellLists::read_at(GLuint table_unit, GLuint lists_unit) const {
  table_.read_at(table_unit);
  lists_.read_at(lists_unit);
}

CellLists kernel_cells(const SampleSet& samples, const SplatField& field) {
  std::vector<float> radii;
  for (std::uint32_t i = 0; i < samples.size(); ++i) radii.push_back(field.radius(i));
  if (radii.empty()) radii.push_back(1.0F);
  std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2),
                   radii.end());
  const float cell = std::max(kCellRadii * radii[radii.size() / 2], 1e-30F);
  const float half_diagonal = 0.5F * std::sqrt(3.0F) * cell;
  const auto visit = [&](std::uint32_t i, const CellLists::Add& add) {
    const Vec3f& p = samples.positions[i];
    const float reach = kReach * field.radius(i);
    const Cell low = cell_of(p - Vec3f::Constant(reach), 1.0F / cell);
    const Cell high = cell_of(p + Vec3f::Constant(reach), 1.0F / cell);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Vec3f offset = cell * (Vec3f(x, y, z) + Vec3f::Constant(0.5F)) - p;
          const float across = std::abs(offset.dot(samples.normals[i]));
          if (across > kReachAcross * field.radius(i) + half_diagonal) continue;
          if (offset.norm() > reach + half_diagonal) continue;
          add({x, y, z});
        }
      }
    }
  };
  return {samples.size(), cell, visit};
}

CellLists plain_cells(const SampleSet& samples, const SplatField& field) {
  const float cell = std::max(kSplatReach * field.largest_radius(), 1e-30F);
  return {samples.size(), cell, [&](std::uint32_t i, const CellLists::Add& add) {
            add(cell_of(samples.positions[i], 1.0F / cell));
          }};
}

}  // namespace prt::gl
