#include "player/visible_surfaces.h"

#include "base/parallel.h"

namespace prt {
namespace {

constexpr std::size_t kGrain = 4096;

/// The shading normal at a fragment, on the side of the geometric one.
Vec3f shading_normal(const Scene& scene, const Fragment& fragment, const SurfacePoint& surface) {
  const auto& vertex = scene.triangles[fragment.triangle].vertex;
  const Vec3f blended = (1.0F - fragment.u - fragment.v) * scene.normals[vertex[0]] +
                        fragment.u * scene.normals[vertex[1]] +
                        fragment.v * scene.normals[vertex[2]];
  const float length = blended.norm();
  if (!(length > 1e-3F)) return surface.normal;
  const Vec3f normal = (surface.front ? 1.0F : -1.0F) / length * blended;
  return normal.dot(surface.normal) > 0.0F ? normal : surface.normal;
}

}  // namespace

VisibleSurfaces visible_surfaces(const Scene& scene, const Vec3f& eye, const FragmentImage& image,
                                 unsigned threads) {
  VisibleSurfaces surfaces;
  for (std::uint32_t i = 0; i < image.fragments.size(); ++i) {
    if (image.fragments[i].triangle != kNone) surfaces.place.push_back(i);
  }
  surfaces.points.resize(surfaces.place.size());
  surfaces.albedo.resize(surfaces.place.size());
  parallel_for(surfaces.place.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Fragment& f = image.fragments[surfaces.place[i]];
      const Vec3f position = triangle_point(scene, f.triangle, f.u, f.v);
      const SurfacePoint surface =
          surface_at(scene, {eye, (position - eye).normalized()}, {f.triangle, 0.0F, f.u, f.v});
      surfaces.points[i] = {surface.position, surface.normal, shading_normal(scene, f, surface)};
      surfaces.albedo[i] = albedo_at(scene, f.triangle, f.u, f.v);
    }
  });
  return surfaces;
}

}  // namespace prt
