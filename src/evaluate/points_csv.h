// Points in and irradiance out, as CSV.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "transport/path_tracer.h"

namespace prt {

/// A point as users write it.
struct WorldPoint {
  Vec3d position;  ///< m, world
  Vec3f normal;    ///< unit
};

/// Reads `x,y,z,nx,ny,nz` (exactly this header; m; normals are made unit). Throws UserError with
/// file and line: missing file, another header, wrong number of columns, not a finite number, zero
/// normal, no points.
std::vector<WorldPoint> read_points_csv(const std::filesystem::path& file);

/// The points in a scene of that origin.
std::vector<ReceiverPoint> points_in(const Vec3d& origin, std::span<const WorldPoint> points);

/// Irradiance at a point, W/m², unclamped; NaN where it is not known.
struct PointIrradiance {
  Vec3f direct = Vec3f::Zero();
  Vec3f indirect = Vec3f::Zero();
};

/// Writes the points, where they were read, with direct_r … indirect_b; all numbers have so many
/// digits that they read back exactly; unknown ones are `nan`. The file gets its name only when it
/// is whole. Throws UserError if it cannot be written.
void write_points_csv(const std::filesystem::path& file, std::span<const WorldPoint> points,
                      std::span<const PointIrradiance> values);

}  // namespace prt
