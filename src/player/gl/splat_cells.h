// Which samples may matter at a place, so that a pixel looks into one cell only. Internal to
// player/gl.
#pragma once

#include <functional>

#include "domains/splats.h"
#include "player/gl/objects.h"

namespace prt::gl {

using Cell = Eigen::Vector3i;

/// Cells of a uniform grid and the samples listed for each, as a hash table on the GL. A slot holds
/// the cell's key (two words) and the first and last texel of its list (shaders/splats.glsl).
class CellLists {
 public:
  /// Calls `visit(sample, add)` twice for each sample; it calls add(cell) for the sample's cells.
  using Add = std::function<void(const Cell&)>;
  CellLists(std::size_t samples, float cell,
            const std::function<void(std::uint32_t sample, const Add& add)>& visit);
  void read_at(GLuint table_unit, GLuint lists_unit) const;
  [[nodiscard]] float inverse_cell() const { return inverse_cell_; }
  [[nodiscard]] std::uint32_t slot_mask() const { return slot_mask_; }

 private:
  float inverse_cell_;
  std::uint32_t slot_mask_ = 0;
  TexelBuffer table_;
  TexelBuffer lists_;
};

/// The cell of a place, clamped where the grid ends.
Cell cell_of(const Vec3f& p, float inverse_cell);

/// For each cell, the samples whose kernels reach into it and are not weak there.
CellLists kernel_cells(const SampleSet& samples, const SplatField& field);
/// For each cell, the samples in it.
CellLists plain_cells(const SampleSet& samples, const SplatField& field);

}  // namespace prt::gl
