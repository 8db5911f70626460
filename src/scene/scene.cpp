#include "scene/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace prt {

std::uint64_t RepairReport::total() const {
  return degenerate_triangles + non_finite_triangles + singular_transforms + skipped_primitives +
         missing_normals + bad_normals + clamped_albedos;
}

namespace {

std::array<const Vec3f*, 3> corners(const Scene& scene, std::uint32_t triangle) {
  const auto& vertex = scene.triangles[triangle].vertex;
  return {&scene.positions[vertex[0]], &scene.positions[vertex[1]], &scene.positions[vertex[2]]};
}

/// Normal by winding, its length twice the area. In double: the edges of a needle cancel.
Vec3d doubled_area_vector(const Scene& scene, std::uint32_t triangle) {
  const auto [a, b, c] = corners(scene, triangle);
  const Vec3d origin = a->cast<double>();
  return (b->cast<double>() - origin).cross(c->cast<double>() - origin);
}

}  // namespace

SurfacePoint surface_at(const Scene& scene, const Ray& ray, const Hit& hit) {
  SurfacePoint point;
  point.position = triangle_point(scene, hit.triangle, hit.u, hit.v);
  point.normal = triangle_normal(scene, hit.triangle);
  point.triangle = hit.triangle;
  point.u = hit.u;
  point.v = hit.v;
  point.front = point.normal.dot(ray.direction) <= 0.0F;
  if (!point.front) point.normal = -point.normal;
  return point;
}

Vec3f triangle_point(const Scene& scene, std::uint32_t triangle, float u, float v) {
  const auto [a, b, c] = corners(scene, triangle);
  return (1.0F - u - v) * *a + u * *b + v * *c;
}

Vec3f triangle_normal(const Scene& scene, std::uint32_t triangle) {
  return doubled_area_vector(scene, triangle).normalized().cast<float>();
}

double triangle_area(const Scene& scene, std::uint32_t triangle) {
  return 0.5 * doubled_area_vector(scene, triangle).norm();
}

Vec3f offset_origin(const Scene& scene, const Vec3f& position, const Vec3f& normal) {
  // The first term scales with the scene and does not vanish at its centre; the second is eight
  // float spacings of the coordinates, for scenes that lie far from the origin.
  const Vec3f centre = 0.5F * (scene.bounds_min + scene.bounds_max);
  const float from_centre =
      std::max((position - centre).cwiseAbs().maxCoeff(), scene.diagonal() / 16.0F);
  const float distance = 0x1p-16F * from_centre + 0x1p-21F * position.cwiseAbs().maxCoeff();
  return position + distance * normal;
}

std::vector<std::uint32_t> triangles_by_material(const Scene& scene) {
  std::vector<std::uint32_t> order(scene.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return scene.triangles[a].material < scene.triangles[b].material;
  });
  return order;
}

}  // namespace prt
