// The static scene as light transport sees it: one list of triangles in one frame with Lambert
// materials, made from a glTF 2.0 file (scene/load.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/hash.h"
#include "base/types.h"

namespace prt {

/// Decoded base-colour texture: 8-bit sRGB colour and linear alpha, as stored in the file.
struct Texture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< height × width × 4, first row is v = 0
  enum class Wrap { kRepeat, kClamp, kMirror } wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  std::vector<std::byte> encoded;  ///< the file's own PNG or JPEG bytes, to go into a package
  std::string mime_type;           ///< "image/png" or "image/jpeg"
};

/// Lambert surface: albedo = base_color × texture (sRGB decoded), clamped to [0, 1].
struct Material {
  std::string name;
  Vec3f base_color = Vec3f::Ones();  ///< linear
  float base_alpha = 1.0F;
  std::uint32_t texture = kNone;  ///< index into Scene::textures
  bool alpha_mask = false;        ///< alphaMode MASK: surface exists where alpha >= alpha_cutoff
  float alpha_cutoff = 0.5F;
  bool double_sided = false;  ///< for viewers only: transport uses the side that is hit
};

struct Triangle {
  std::array<std::uint32_t, 3> vertex;  ///< indices into Scene::positions and so on
  std::uint32_t material;               ///< index into Scene::materials
  std::uint32_t surface;                ///< number of the glTF primitive instance it came from
};

/// A light as the glTF file offers it (KHR_lights_punctual), in our radiometric units.
struct SceneLight {
  enum class Kind { kPoint, kSpot, kSun } kind = Kind::kPoint;
  std::string name;
  Vec3f position = Vec3f::Zero();
  Vec3f direction = -Vec3f::UnitZ();  ///< unit, the way the light travels
  Vec3f intensity = Vec3f::Zero();    ///< W/sr; for kSun irradiance on a facing plane, W/m²
  float inner_angle = 0.0F;           ///< radians from the axis, kSpot
  float outer_angle = 0.7853982F;
};

struct SceneCamera {
  Vec3f eye = Vec3f::Zero();
  Vec3f target = -Vec3f::UnitZ();
  Vec3f up = Vec3f::UnitY();
  float vertical_fov = 0.9F;  ///< radians
};

/// What had to be mended or left out while loading; all zero for a sound scene.
struct RepairReport {
  std::uint64_t degenerate_triangles = 0;  ///< zero area, or an index twice
  std::uint64_t non_finite_triangles = 0;
  std::uint64_t singular_transforms = 0;  ///< nodes whose geometry was left out
  std::uint64_t skipped_primitives = 0;   ///< points and lines
  std::uint64_t missing_normals = 0;      ///< primitives whose normals were made from the geometry
  std::uint64_t bad_normals = 0;          ///< vertex normals replaced (zero, non-finite)
  std::uint64_t clamped_albedos = 0;      ///< base colours outside [0, 1]
  std::vector<std::string> notes;         ///< one readable line for each kind of repair made
  [[nodiscard]] std::uint64_t total() const;
};

struct Scene {
  /// Where (0, 0, 0) of all coordinates here lies in the world, m. Zero unless the scene lies so
  /// far out that float would be coarse there (load_scene); axes are the world's. What users type
  /// and read is in the world: relative_to() takes it here.
  Vec3d origin = Vec3d::Zero();
  [[nodiscard]] bool recentred() const { return origin != Vec3d::Zero(); }

  std::vector<Vec3f> positions;  ///< m
  std::vector<Vec3f> normals;    ///< unit shading normals, one per position
  std::vector<Vec2f> uvs;        ///< one per position; zero where the file has none
  std::vector<Triangle> triangles;
  std::vector<Material> materials;  ///< never empty if there is a triangle
  std::vector<Texture> textures;
  std::vector<SceneLight> lights;
  std::optional<SceneCamera> camera;  ///< the file's first camera
  RepairReport repairs;
  double vertex_rounding =
      0.0;  ///< m: what vertices may be off by the file's own float coordinates

  /// Three separate content hashes, so that a changed albedo leaves ray casts valid.
  Digest geometry_hash;   ///< positions, triangles, curvature-relevant normals, alpha masks (uv and
                          ///< alpha of masked)
  Digest materials_hash;  ///< albedo: factors, textures, uvs, material of each triangle
  Digest lights_hash;     ///< lights and camera

  Vec3f bounds_min = Vec3f::Zero();
  Vec3f bounds_max = Vec3f::Zero();
  /// Length of the bounding box's diagonal: no distance in the scene is longer.
  [[nodiscard]] float diagonal() const { return (bounds_max - bounds_min).norm(); }
};

/// A place in the world as a place in a scene of that origin (Scene::origin): the difference of
/// large numbers is taken in double. Metres.
inline Vec3f relative_to(const Vec3d& origin, const Vec3d& world) {
  return (world - origin).cast<float>();
}

/// A ray; direction is unit, so that t is a distance in metres.
struct Ray {
  Vec3f origin;
  Vec3f direction;
  float t_near = 0.0F;
  float t_far = kInfinity;
};

/// Where a ray ends. triangle == kNone: it escaped.
struct Hit {
  std::uint32_t triangle = kNone;
  float t = kInfinity;
  float u = 0.0F;  ///< barycentric weight of vertex 1
  float v = 0.0F;  ///< barycentric weight of vertex 2
  [[nodiscard]] bool escaped() const { return triangle == kNone; }
};

/// The geometry at a hit, on the side that was hit. This one function serves the sampler, the
/// gather, the photons and the path tracer, so that they agree on sides.
struct SurfacePoint {
  Vec3f position;
  Vec3f normal;  ///< unit geometric normal, facing against the ray
  std::uint32_t triangle = kNone;
  float u = 0.0F;
  float v = 0.0F;
  bool front = true;  ///< the side from which the triangle's winding is counter-clockwise
};
SurfacePoint surface_at(const Scene& scene, const Ray& ray, const Hit& hit);

/// Point of a triangle by barycentric weights of vertices 1 and 2.
Vec3f triangle_point(const Scene& scene, std::uint32_t triangle, float u, float v);
/// Unit geometric normal by winding (counter-clockwise is front).
Vec3f triangle_normal(const Scene& scene, std::uint32_t triangle);
double triangle_area(const Scene& scene, std::uint32_t triangle);
/// All triangles, those of a material together, in the order of the scene.
std::vector<std::uint32_t> triangles_by_material(const Scene& scene);

/// Linear RGB albedo in [0, 1] at a point of a triangle: base colour × bilinear texture (sRGB
/// decoded).
Vec3f albedo_at(const Scene& scene, std::uint32_t triangle, float u, float v);
/// True if the surface exists there (alphaMode MASK).
bool opaque_at(const Scene& scene, std::uint32_t triangle, float u, float v);

/// A ray origin just off the surface on the side of `normal`. The distance follows the float
/// spacing of the coordinates (about 2^-16 of the distance from the scene's centre), so it scales
/// with the scene.
Vec3f offset_origin(const Scene& scene, const Vec3f& position, const Vec3f& normal);

}  // namespace prt
