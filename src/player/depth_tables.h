// Depth buffers laid out for speed: the depths of any direction at a sample are one dot product of
// two contiguous rows. Internal to player/.
#pragma once

#include <array>
#include <span>
#include <variant>
#include <vector>

#include "package/package.h"
#include "player/direction_cells.h"

namespace prt {

/// Something that shines, as a surface point sees it.
struct ShiningPlace {
  Vec3f to_light;  ///< unit, world
  float distance;  ///< m; kInfinity from outside the scene
};

class DepthTables {
 public:
  /// Lays out a package's depth buffers; both must outlive the tables.
  DepthTables(const DepthVisibility& visibility, const SampleSet& samples);

  /// What a thread works with, for any tables; it grows with what is asked for.
  struct Scratch {
    DirectionCells cells;
    std::vector<float> weights;
    std::vector<std::uint32_t> asked;      ///< by direction: the question it was last part of
    std::vector<float> depths;             ///< by direction
    std::vector<std::int32_t> directions;  ///< asked for now, once each
    std::uint32_t question = 0;
    /// So that as many places at once allocate nothing.
    void make_room(std::size_t places);
  };

  /// Share of light in [0, 1] that comes from each of the places to a sample; `cluster` is its own.
  /// Places of one light share directions: each depth is reconstructed once.
  void visibility(std::uint32_t sample, std::uint32_t cluster, std::span<const ShiningPlace> places,
                  Scratch& scratch, std::span<float> shares) const;

 private:
  /// The basis' numbers as they are stored, directions × stride: rows are padded with zeros to
  /// whole vectors.
  using Numbers =
      std::variant<std::vector<std::int8_t>, std::vector<std::int16_t>, std::vector<float>>;
  struct Cluster {
    const DepthBlock* block = nullptr;
    bool only_walls = false;  ///< nothing but walls is in the way
    std::size_t stride = 0;
    Numbers basis;
    std::vector<float> mean;    ///< directions
    std::vector<float> scales;  ///< stride: of the basis' functions
  };
  static Cluster lay_out(const DepthBlock& block, std::size_t directions);
  void within_walls(std::uint32_t sample, const Cluster& cluster,
                    std::span<const ShiningPlace> places, std::span<float> shares) const;
  /// Factors of the basis' numbers at the row of a cluster's coefficients: those times their
  /// scales.
  static void weigh(const Cluster& cluster, std::size_t row, std::vector<float>& weights);
  /// Lists the directions round the first `places` cells.
  void list_directions(std::size_t places, Scratch& scratch) const;
  /// Depths of the directions listed.
  static void reconstruct(const Cluster& cluster, Scratch& scratch);
  /// The four directions of a cell: next ones in its row and column, or the same at the grid's end.
  [[nodiscard]] std::array<std::int32_t, 4> corners(std::int32_t corner) const {
    return {corner, corner + next_across_, corner + next_along_,
            corner + next_along_ + next_across_};
  }

  const SampleSet* samples_;
  HemisphereDirections directions_;
  std::int32_t next_across_;
  std::int32_t next_along_;
  float bound_;
  float bias_;
  std::vector<Cluster> clusters_;
};

}  // namespace prt
