// Light that comes from infinitely far away: radiance by direction, as a table over the sphere.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/types.h"
#include "scene/light.h"

namespace prt {

/// Radiance (W/(m² sr), RGB) that is constant on each cell of an equirectangular grid: row 0 is
/// next to straight up (+Y), and columns run clockwise as seen from above, from +Z over −X, −Z in
/// the middle and +X back to +Z. Quadratures over cells are then exact in solid angle, and sampling
/// follows radiance exactly.
class Environment {
 public:
  /// `radiance`: width · height values, row by row, finite and not negative.
  Environment(int width, int height, std::vector<Vec3f> radiance);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Radiance of the cells, row by row, before it was turned; and by how much, radians about +Y.
  [[nodiscard]] const std::vector<Vec3f>& cells() const { return radiance_; }
  [[nodiscard]] double turn() const { return turn_; }
  /// Of the cell that holds a unit direction.
  [[nodiscard]] Vec3f radiance(const Vec3f& direction) const;

  /// One sample of what arrives at a point, as of a Light (scene/light.h); density follows the sum
  /// of the channels, so that irradiance · cosine is bounded however small and bright a sun is.
  [[nodiscard]] IncidentLight sample(float u, float v) const;

  /// The same light turned by so many degrees about +Y, counter-clockwise as seen from above.
  [[nodiscard]] Environment turned(double degrees) const;

  /// Calls visit(unit direction, solid angle in sr, radiance) for the whole sphere, in pieces of
  /// cells, of at least `least` rows.
  template <typename Visit>
  void visit(int least, Visit&& visit_piece) const {
    const int split = std::max(1, (least + height_ - 1) / height_);
    for (int row = 0; row < height_ * split; ++row) {
      const double weight = piece_solid_angle(row, split);
      for (int column = 0; column < width_ * split; ++column) {
        visit_piece(
            piece_direction(row, column, split), weight,
            radiance_[static_cast<std::size_t>(row / split) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(column / split)]);
      }
    }
  }

 private:
  [[nodiscard]] double piece_solid_angle(int row, int split) const;
  [[nodiscard]] Vec3d piece_direction(int row, int column, int split) const;
  [[nodiscard]] Vec3d from_grid(double up, double across) const;
  void prepare_sampling();

  int width_, height_;
  double turn_ = 0.0;  ///< radians
  std::vector<Vec3f> radiance_;
  std::vector<double> rows_;    ///< power up to and including each row, sum of the channels
  std::vector<float> columns_;  ///< share of the row's power up to and including each column
};

/// Parses a SPEC of the command line and reads the file that it names:
///
///   sky:r,g,b                      the same radiance all around
///   gradient:r,g,b:r,g,b:r,g,b     radiance straight up, at the horizon, straight down
///   lobes:r,g,b                    the two lights of the tutorial (SH §6.2.4), times r,g,b; its
///                                  polar axis is straight up
///   disc:dx,dy,dz:r,g,b:degrees    a sun of that angular radius; its light travels along d
///   map:FILE.hdr|.exr              equirectangular picture, 2 : 1, its middle is −Z
///   probe:FILE.hdr|.exr            angular map (light probe), square; its middle is +Z
///   FILE.hdr|.exr                  as map:
///
/// r,g,b is radiance in W/(m² sr). Throws UserError with the form expected, or what is wrong with
/// the file.
Environment parse_environment(std::string_view spec);

/// The forms above in one line, for --help.
inline constexpr const char* kEnvironmentForms =
    "sky:r,g,b | gradient:r,g,b:r,g,b:r,g,b (up, horizon, down) | lobes:r,g,b | "
    "disc:dx,dy,dz:r,g,b:radius_deg | map:FILE | probe:FILE | FILE, an equirectangular .hdr or "
    ".exr; radiance in W/(m² sr)";

}  // namespace prt
