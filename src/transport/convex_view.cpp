#include "transport/convex_view.h"

#include <algorithm>
#include <vector>

#include "bases/depth_basis.h"
#include "transport/hemisphere.h"

namespace prt {

namespace {

/// Planes closer than this, as a share of the bound and in their unit normals, are one wall.
constexpr float kSamePlane = 1e-5F;

using Wall = Eigen::Vector4f;

Wall wall_at(const SampleSet& samples, std::uint32_t s) {
  const Vec3f outward = -samples.normals[s];
  return {outward.x(), outward.y(), outward.z(), outward.dot(samples.positions[s])};
}

bool same(const Wall& a, const Wall& b, const Vec3f& at, float bound) {
  return (a - b).head<3>().norm() <= kSamePlane &&
         std::abs(a.head<3>().dot(at) - a[3]) <= kSamePlane * bound;
}

/// The planes of all senders, in the order of the samples; none if there are too many.
std::optional<std::vector<Wall>> planes_of(const SampleSet& samples,
                                           const std::vector<std::uint8_t>& is_sender,
                                           float bound) {
  std::vector<Wall> walls;
  for (std::uint32_t s = 0; s < samples.size(); ++s) {
    if (is_sender[s] == 0) continue;
    const Wall plane = wall_at(samples, s);
    if (std::ranges::any_of(walls, [&](const Wall& known) {
          return same(known, plane, samples.positions[s], bound);
        })) {
      continue;
    }
    if (std::ssize(walls) == kMostWalls) return std::nullopt;
    walls.push_back(plane);
  }
  return walls;
}

/// How far p is outside the walls, m; negative inside.
float outside(const std::vector<Wall>& walls, const Vec3f& p) {
  float most = -kInfinity;
  for (const Wall& wall : walls) most = std::max(most, wall.head<3>().dot(p) - wall[3]);
  return most;
}

bool all_end_on(const std::vector<Wall>& walls, const SampleSet& samples,
                const HemisphereDirections& directions, const ClusterView& view) {
  const float slack = kWallSlack * view.bound;
  const auto count = static_cast<std::size_t>(directions.count());
  for (std::uint32_t s = view.begin; s < view.end; ++s) {
    const Vec3f& origin = samples.positions[s];
    if (outside(walls, origin) > slack) return false;
    const Mat3f frame = samples.frame(s);
    const std::uint16_t* distance = view.distances.data() + (s - view.begin) * count;
    for (std::size_t d = 0; d < count; ++d) {
      const float z = unpack_depth(distance[d]);
      const Vec3f ray = frame * directions.direction(static_cast<int>(d));
      if (std::abs(outside(walls, origin + view.bound * z * z * ray)) > slack) return false;
    }
  }
  return true;
}

/// Whether no way leads out to infinity, past all walls, from the front of a surface. Rays leave
/// gaps between them: in a long corridor none may meet what stands at its far end, and the walls
/// that are met do not say that there is one.
bool is_bounded(const std::vector<Wall>& walls, const Vec3f& front) {
  constexpr float kSlack = 1e-4F;
  std::vector<Vec3f> outwards = {-front};
  for (const Wall& wall : walls) outwards.push_back(wall.head<3>());
  const auto leads_out = [&](const Vec3f& way) {
    return std::ranges::none_of(outwards, [&](const Vec3f& n) { return n.dot(way) > kSlack; });
  };
  // A cone of ways has an edge along which two planes meet, or is a line, half plane or more.
  bool turns = false;
  for (std::size_t i = 0; i < outwards.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3f edge = outwards[i].cross(outwards[j]);
      if (edge.norm() < kSlack) continue;
      turns = true;
      if (leads_out(edge.normalized()) || leads_out(-edge.normalized())) return false;
    }
  }
  return turns;
}

bool is_bounded(const std::vector<Wall>& walls, const SampleSet& samples, const ClusterView& view) {
  for (std::uint32_t s = view.begin; s < view.end; ++s) {
    const Vec3f& front = samples.normals[s];
    const bool known = s > view.begin && front == samples.normals[s - 1];
    if (!known && !is_bounded(walls, front)) return false;
  }
  return true;
}

}  // namespace

std::optional<MatrixF> convex_walls(const SampleSet& samples,
                                    const HemisphereDirections& directions,
                                    const ClusterView& view) {
  const std::size_t escaped = std::ranges::count(view.senders, kEscapedSender);
  if (escaped == view.senders.size()) return MatrixF(0, 4);
  if (escaped > 0 || std::ranges::count(view.senders, kLostSender) > 0) return std::nullopt;
  std::vector<std::uint8_t> is_sender(samples.size(), 0);
  for (const std::uint32_t sender : view.senders) is_sender[sender] = 1;
  const auto walls = planes_of(samples, is_sender, view.bound);
  if (!walls || !is_bounded(*walls, samples, view) ||
      !all_end_on(*walls, samples, directions, view)) {
    return std::nullopt;
  }
  MatrixF rows(std::ssize(*walls), 4);
  for (Eigen::Index w = 0; w < rows.rows(); ++w) rows.row(w) = (*walls)[w].transpose();
  return rows;
}

}  // namespace prt
