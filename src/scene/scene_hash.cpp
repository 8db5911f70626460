#include "scene/scene_hash.h"

#include <span>
#include <type_traits>

namespace prt {
namespace {

// Values are hashed one after the other, never as whole structures: those have padding.
template <typename T>
void add(Hasher& hasher, const T& value) {
  hasher.add_values(std::span<const T>(&value, 1));
}

template <typename T>
void add_array(Hasher& hasher, const std::vector<T>& values) {
  hasher.add_values(std::span<const T>(values));
}

void add_vector(Hasher& hasher, const Vec3f& v) {
  hasher.add_values(std::span<const float>(v.data(), 3));
}

void add_vectors(Hasher& hasher, const std::vector<Vec3f>& vectors) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  const float* data = vectors.empty() ? nullptr : vectors.data()->data();
  hasher.add_values(std::span<const float>(data, 3 * vectors.size()));
}

void add_vectors(Hasher& hasher, const std::vector<Vec2f>& vectors) {
  static_assert(sizeof(Vec2f) == 2 * sizeof(float));
  const float* data = vectors.empty() ? nullptr : vectors.data()->data();
  hasher.add_values(std::span<const float>(data, 2 * vectors.size()));
}

void add_wrap(Hasher& hasher, const Texture& texture) {
  add(hasher, static_cast<int>(texture.wrap_u));
  add(hasher, static_cast<int>(texture.wrap_v));
}

/// What opaque_at() reads, for one masked material.
Digest mask_hash(const Scene& scene, const Material& material) {
  Hasher hasher;
  add(hasher, material.base_alpha);
  add(hasher, material.alpha_cutoff);
  if (material.texture != kNone) {
    const Texture& texture = scene.textures[material.texture];
    add(hasher, texture.width);
    add(hasher, texture.height);
    add_wrap(hasher, texture);
    std::vector<std::uint8_t> alpha(texture.rgba.size() / 4);
    for (std::size_t i = 0; i < alpha.size(); ++i) alpha[i] = texture.rgba[4 * i + 3];
    add_array(hasher, alpha);
  }
  return hasher.digest();
}

Digest geometry_hash(const Scene& scene) {
  std::vector<Digest> masks(scene.materials.size());
  for (std::size_t m = 0; m < masks.size(); ++m) {
    if (scene.materials[m].alpha_mask) masks[m] = mask_hash(scene, scene.materials[m]);
  }
  Hasher hasher;
  add_vectors(hasher, scene.positions);
  add_vectors(hasher, scene.normals);
  std::vector<std::uint32_t> corners;
  corners.reserve(4 * scene.triangles.size());
  for (const Triangle& triangle : scene.triangles) {
    corners.insert(corners.end(), triangle.vertex.begin(), triangle.vertex.end());
    corners.push_back(triangle.surface);
  }
  add_array(hasher, corners);
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const Triangle& triangle = scene.triangles[t];
    if (!scene.materials[triangle.material].alpha_mask) continue;
    add(hasher, t);
    add(hasher, masks[triangle.material].high);
    add(hasher, masks[triangle.material].low);
    for (const std::uint32_t vertex : triangle.vertex) {
      hasher.add_values(std::span<const float>(scene.uvs[vertex].data(), 2));
    }
  }
  return hasher.digest();
}

/// Names and encoded images belong to it as well: a package holds them.
Digest materials_hash(const Scene& scene) {
  Hasher hasher;
  for (const Material& material : scene.materials) {
    hasher.add(material.name);
    add_vector(hasher, material.base_color);
    add(hasher, material.base_alpha);
    add(hasher, material.texture);
    add(hasher, material.alpha_mask);
    add(hasher, material.alpha_cutoff);
    add(hasher, material.double_sided);
  }
  for (const Texture& texture : scene.textures) {
    add(hasher, texture.width);
    add(hasher, texture.height);
    add_wrap(hasher, texture);
    add_array(hasher, texture.rgba);
    add_array(hasher, texture.encoded);
  }
  add_vectors(hasher, scene.uvs);
  std::vector<std::uint32_t> assignment;
  assignment.reserve(scene.triangles.size());
  for (const Triangle& triangle : scene.triangles) assignment.push_back(triangle.material);
  add_array(hasher, assignment);
  return hasher.digest();
}

Digest lights_hash(const Scene& scene) {
  Hasher hasher;
  for (const SceneLight& light : scene.lights) {
    add(hasher, static_cast<int>(light.kind));
    hasher.add(light.name);
    add_vector(hasher, light.position);
    add_vector(hasher, light.direction);
    add_vector(hasher, light.intensity);
    add(hasher, light.inner_angle);
    add(hasher, light.outer_angle);
  }
  if (scene.camera) {
    add_vector(hasher, scene.camera->eye);
    add_vector(hasher, scene.camera->target);
    add_vector(hasher, scene.camera->up);
    add(hasher, scene.camera->vertical_fov);
  }
  return hasher.digest();
}

}  // namespace

void hash_scene(Scene& scene) {
  scene.geometry_hash = geometry_hash(scene);
  scene.materials_hash = materials_hash(scene);
  scene.lights_hash = lights_hash(scene);
}

}  // namespace prt
