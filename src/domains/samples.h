// Sample points: the domain on which light is represented (Leonhardt & Bohn, §4.1).
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "base/types.h"

namespace prt {

/// Samples sorted by cluster: cluster c owns the contiguous range [cluster_begin[c],
/// cluster_begin[c+1]).
struct SampleSet {
  std::vector<Vec3f> positions;  ///< m, about Scene::origin
  std::vector<Vec3f> normals;    ///< unit geometric normal on the side the sample stands for
  std::vector<Vec3f> tangents;   ///< unit, orthogonal to the normal, smooth within a cluster
  std::vector<float> areas;      ///< area of the sample's cell, m²; its weight in inner products
  std::vector<float> radii;      ///< Poisson-disk radius that held at the sample, m
  std::vector<std::uint32_t> triangles;      ///< Scene::triangles
  std::vector<std::uint32_t> cluster_begin;  ///< clusters + 1 entries

  [[nodiscard]] std::size_t size() const { return positions.size(); }
  [[nodiscard]] std::size_t clusters() const {
    return cluster_begin.empty() ? 0 : cluster_begin.size() - 1;
  }
  [[nodiscard]] std::uint32_t cluster_size(std::size_t c) const {
    return cluster_begin[c + 1] - cluster_begin[c];
  }
  [[nodiscard]] std::vector<std::uint32_t> cluster_of_sample() const;
  /// Columns: tangent, normal × tangent, normal. World = frame · local.
  [[nodiscard]] Mat3f frame(std::size_t i) const;
};

/// Two surface points may stand for each other when their normals agree to within 60°.
inline constexpr float kCompatibleCosine = 0.5F;

/// How much more an offset along a surface's normal counts than one within the surface when the
/// nearest sample is looked for. A thin wall is near what faces it, and yet another surface:
/// counted alike, hits on a wall of few samples took the light of the room behind it.
inline constexpr float kOffPlane = 4.0F;

/// Squared distance by which samples are nearest to a point of a surface with unit normal n:
/// `offset` is sample − point, m.
inline float squared_distance_off(const Vec3f& offset, const Vec3f& n) {
  const float height = n.dot(offset);
  return offset.squaredNorm() + (kOffPlane * kOffPlane - 1.0F) * height * height;
}

/// Uniform grid over sample positions for neighbour queries. Results are independent of insertion
/// order: ties go to the lowest index. Holds copies of what it needs.
class SampleGrid {
 public:
  SampleGrid() = default;
  /// `cell` is the side of a grid cell, m: best the largest common query radius.
  SampleGrid(std::span<const Vec3f> positions, std::span<const Vec3f> normals, float cell);

  /// The sample nearest to p by squared_distance_off() with n·n_s >= min_cosine, of those within
  /// `radius` all around, or kNone.
  [[nodiscard]] std::uint32_t nearest(const Vec3f& p, const Vec3f& n, float radius,
                                      float min_cosine = kCompatibleCosine) const;
  /// All samples within radius (any normal), appended to out in ascending index order per cell.
  void within(const Vec3f& p, float radius, std::vector<std::uint32_t>& out) const;
  /// The same, of the samples with n·n_s >= kCompatibleCosine.
  void within(const Vec3f& p, const Vec3f& n, float radius, std::vector<std::uint32_t>& out) const;

 private:
  struct Entry {
    Vec3f position;
    std::uint32_t index;
    Vec3f normal;
    std::uint32_t unused = 0;
  };
  [[nodiscard]] std::size_t slot(int x, int y, int z) const;
  struct Nearest {
    float squared_radius;  ///< all around
    float squared_distance = kInfinity;
    std::uint32_t index = kNone;
    [[nodiscard]] float reach() const { return std::min(squared_radius, squared_distance); }
  };
  void scan(std::size_t slot, const Vec3f& p, const Vec3f& n, float min_cosine,
            Nearest& best) const;
  template <typename Visit>
  void visit_cells(const Vec3f& p, float radius, Visit&& visit) const;
  template <typename Accept>
  void collect(const Vec3f& p, float radius, std::vector<std::uint32_t>& out,
               Accept&& accept) const;

  std::vector<Entry> entries_;        // sorted by hashed cell
  std::vector<std::uint32_t> begin_;  // slots + 1
  std::uint32_t slot_mask_ = 0;
  float inverse_cell_ = 1.0F;
};

}  // namespace prt
