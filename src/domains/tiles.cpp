#include "domains/tiles.h"

#include <algorithm>
#include <span>

namespace prt {

struct Tiles::Part {
  std::span<Vec3f> points;
  std::size_t tiles;
  Box box;
};

Tiles::Tiles(std::vector<Vec3f> points, std::size_t count) { halve({points, count, {}}); }

void Tiles::halve(const Part& part) {
  if (part.tiles == 1 || part.points.empty()) {
    boxes_.push_back(part.box);
    return;
  }
  Vec3f low = part.points[0];
  Vec3f high = low;
  for (const Vec3f& p : part.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t tiles = part.tiles / 2;
  const std::size_t before = part.points.size() * tiles / part.tiles;
  const auto middle = part.points.begin() + static_cast<std::ptrdiff_t>(before);
  std::nth_element(part.points.begin(), middle, part.points.end(),
                   [&](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
  Part below{part.points.first(before), tiles, part.box};
  Part above{part.points.subspan(before), part.tiles - tiles, part.box};
  below.box.high[axis] = above.box.low[axis] = (*middle)[axis];
  halve(below);
  halve(above);
}

bool Tiles::contains(std::size_t tile, const Vec3f& p) const {
  const Box& box = boxes_[tile];
  return (p.array() >= box.low.array()).all() && (p.array() < box.high.array()).all();
}

float Tiles::distance(std::size_t tile, const Vec3f& p) const {
  const Box& box = boxes_[tile];
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(Vec3f::Zero()).norm();
}

}  // namespace prt
