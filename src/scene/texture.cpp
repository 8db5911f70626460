// Albedo and alpha of a point: base colour × bilinear texture.
#include <algorithm>
#include <array>
#include <cmath>

#include "scene/scene.h"

namespace prt {
namespace {

/// sRGB's transfer curve (IEC 61966-2-1) for all 8-bit values.
const std::array<float, 256>& linear_from_srgb() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double s = static_cast<double>(i) / 255.0;
      values[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table;
}

int wrapped(int texel, int size, Texture::Wrap wrap) {
  if (wrap == Texture::Wrap::kClamp) return std::clamp(texel, 0, size - 1);
  const int period = wrap == Texture::Wrap::kMirror ? 2 * size : size;
  int in_period = texel % period;
  if (in_period < 0) in_period += period;
  return in_period < size ? in_period : period - 1 - in_period;
}

/// The two texels beside a coordinate and the weight of the second. Texel i has its centre at i +
/// ½.
struct Neighbours {
  int first;
  int second;
  float weight;
};

Neighbours neighbours(float coordinate, int size, Texture::Wrap wrap) {
  // Two periods are enough for every wrap mode, and keep large coordinates within int.
  double u = coordinate;
  if (wrap != Texture::Wrap::kClamp) u -= 2.0 * std::floor(0.5 * u);
  const double texel = std::clamp(u, -1.0, 2.0) * size - 0.5;
  const double below = std::floor(texel);
  const int first = static_cast<int>(below);
  return {wrapped(first, size, wrap), wrapped(first + 1, size, wrap),
          static_cast<float>(texel - below)};
}

/// Calls add(texel pointer, weight) for the four texels around a point of the texture.
template <typename Add>
void for_texels(const Texture& texture, const Vec2f& uv, Add&& add) {
  const Neighbours x = neighbours(uv.x(), texture.width, texture.wrap_u);
  const Neighbours y = neighbours(uv.y(), texture.height, texture.wrap_v);
  const auto texel = [&](int column, int row) {
    const auto index = static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width) +
                       static_cast<std::size_t>(column);
    return &texture.rgba[4 * index];
  };
  add(texel(x.first, y.first), (1.0F - x.weight) * (1.0F - y.weight));
  add(texel(x.second, y.first), x.weight * (1.0F - y.weight));
  add(texel(x.first, y.second), (1.0F - x.weight) * y.weight);
  add(texel(x.second, y.second), x.weight * y.weight);
}

Vec2f uv_at(const Scene& scene, const Triangle& triangle, float u, float v) {
  return (1.0F - u - v) * scene.uvs[triangle.vertex[0]] + u * scene.uvs[triangle.vertex[1]] +
         v * scene.uvs[triangle.vertex[2]];
}

}  // namespace

Vec3f albedo_at(const Scene& scene, std::uint32_t triangle, float u, float v) {
  const Triangle& where = scene.triangles[triangle];
  const Material& material = scene.materials[where.material];
  Vec3f albedo = material.base_color;
  if (material.texture != kNone) {
    const auto& linear = linear_from_srgb();
    Vec3f colour = Vec3f::Zero();
    for_texels(scene.textures[material.texture], uv_at(scene, where, u, v),
               [&](const std::uint8_t* rgba, float weight) {
                 colour += weight * Vec3f(linear[rgba[0]], linear[rgba[1]], linear[rgba[2]]);
               });
    albedo = albedo.cwiseProduct(colour);
  }
  return albedo.cwiseMax(0.0F).cwiseMin(1.0F);
}

bool opaque_at(const Scene& scene, std::uint32_t triangle, float u, float v) {
  const Triangle& where = scene.triangles[triangle];
  const Material& material = scene.materials[where.material];
  if (!material.alpha_mask) return true;
  float alpha = material.base_alpha;
  if (material.texture != kNone) {
    float texture_alpha = 0.0F;
    for_texels(scene.textures[material.texture], uv_at(scene, where, u, v),
               [&](const std::uint8_t* rgba, float weight) { texture_alpha += weight * rgba[3]; });
    alpha *= texture_alpha / 255.0F;
  }
  return alpha >= material.alpha_cutoff;
}

}  // namespace prt
