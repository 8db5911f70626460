#include "scene/closest_point.h"

namespace prt {

Vec3f closest_point(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0F && d2 <= 0.0F) return a;
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0F && d4 <= d3) return b;
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0F && d5 <= d6) return c;
  // Barycentric weights of c, b and a, times the squared double area: their signs tell the region.
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) return a + d1 / (d1 - d3) * ab;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) return a + d2 / (d2 - d6) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0F && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const float scale = 1.0F / (va + vb + vc);
  return a + vb * scale * ab + vc * scale * ac;
}

}  // namespace prt
