#include "player/direction_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "player/dot.h"

namespace prt {
namespace {

using EightIndices = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

EightFloats all(float value) { return value - EightFloats{}; }
EightFloats smaller(const EightFloats& a, const EightFloats& b) { return a < b ? a : b; }
EightFloats larger(const EightFloats& a, const EightFloats& b) { return a > b ? a : b; }
EightFloats clamped(const EightFloats& v, float low, float high) {
  return smaller(larger(v, all(low)), all(high));
}

EightFloats root(const EightFloats& v) {
#ifdef __AVX2__
  return _mm256_sqrt_ps(v);
#else
  EightFloats roots;
  for (std::size_t lane = 0; lane < kLanes; ++lane) roots[lane] = std::sqrt(v[lane]);
  return roots;
#endif
}

/// Of t in [0, 1]. Odd polynomial with the smallest greatest error, 4e-8: below float's own.
EightFloats arc_tangent(const EightFloats& t) {
  constexpr std::array kFactors{-0.004054561723F, 0.021862939000F,  -0.055912300944F,
                                0.096421957016F,  -0.139086291194F, 0.199465662241F,
                                -0.333298593760F, 0.999999344349F};
  const EightFloats t2 = t * t;
  EightFloats sum{};
  for (const float factor : kFactors) sum = sum * t2 + factor;
  return sum * t;
}

/// A coordinate of the square in cells of which there are n, centres at integers.
EightFloats in_cells(const EightFloats& coordinate, int n) {
  return clamped((coordinate + 1.0F) * (0.5F * static_cast<float>(n)) - 0.5F, 0.0F,
                 static_cast<float>(n - 1));
}

/// The cell that a place is in; the last one at the grid's end, too.
EightIndices cell_of(const EightFloats& place, int n) {
  return __builtin_convertvector(smaller(place, all(static_cast<float>(std::max(0, n - 2)))),
                                 EightIndices);
}

void find_eight(const HemisphereDirections& directions, std::size_t at, DirectionCells& cells) {
  const EightFloats r2 = clamped(1.0F - load(&cells.z[at]), 0.0F, 1.0F);
  const EightFloats to_disk = 1.0F / root(2.0F - r2);
  const EightFloats x = load(&cells.x[at]) * to_disk;
  const EightFloats y = load(&cells.y[at]) * to_disk;
  // The concentric map's inverse (Shirley & Chiu 1997), as domains/directions.cpp has it.
  const EightFloats zero{};
  const EightFloats wide = x < zero ? -x : x;
  const EightFloats high = y < zero ? -y : y;
  const EightFloats r = root(x * x + y * y);
  const EightFloats slope = smaller(wide, high) / larger(larger(wide, high), all(1e-30F));
  const EightFloats minor = r * arc_tangent(slope) * (4.0F / kPi);
  const EightFloats u = wide >= high ? r : minor;
  const EightFloats v = wide >= high ? minor : r;
  const EightFloats fx = in_cells(x < zero ? -u : u, directions.width());
  const EightFloats fy = in_cells(y < zero ? -v : v, directions.height());
  const EightIndices x0 = cell_of(fx, directions.width());
  const EightIndices y0 = cell_of(fy, directions.height());
  const EightIndices corner = y0 * directions.width() + x0;
  const EightFloats across = fx - __builtin_convertvector(x0, EightFloats);
  const EightFloats along = fy - __builtin_convertvector(y0, EightFloats);
  std::memcpy(&cells.corner[at], &corner, sizeof corner);
  std::memcpy(&cells.across[at], &across, sizeof across);
  std::memcpy(&cells.along[at], &along, sizeof along);
}

}  // namespace

void DirectionCells::make_room(std::size_t count) {
  const std::size_t whole = (count + kLanes - 1) / kLanes * kLanes;
  if (x.size() >= whole) return;
  for (auto* values : {&x, &y, &z, &across, &along}) values->resize(whole, 0.0F);
  corner.resize(whole, 0);
}

void find_cells(const HemisphereDirections& directions, std::size_t count, DirectionCells& cells) {
  for (std::size_t at = 0; at < count; at += kLanes) find_eight(directions, at, cells);
}

}  // namespace prt
