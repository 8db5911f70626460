// Closest point of a triangle.
#pragma once

#include "base/types.h"

namespace prt {

/// The point of triangle abc nearest to p (Ericson 2005, Real-Time Collision Detection, §5.1.5).
Vec3f closest_point(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c);

}  // namespace prt
