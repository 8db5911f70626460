#include "player/gl/light_table.h"

#include <array>
#include <cmath>

#include "player/light_samples.h"

namespace prt::gl {
namespace {

constexpr std::array<const char*, 5> kDefines = {"#define LIGHT_POINT\n", "#define LIGHT_SPHERE\n",
                                                 "#define LIGHT_SPOT\n", "#define LIGHT_QUAD\n",
                                                 "#define LIGHT_SUN\n"};

/// A sphere without extent is a point.
Light::Kind played_kind(const Light& light) {
  const bool is_point = light.kind == Light::Kind::kSphere && !(light.radius > 0.0F);
  return is_point ? Light::Kind::kPoint : light.kind;
}

Eigen::Vector4f texel(const Vec3f& xyz, float w) { return {xyz.x(), xyz.y(), xyz.z(), w}; }

}  // namespace

LightTable::LightTable(std::span<const Light> lights, int area_samples)
    : count_(static_cast<int>(lights.size())) {
  std::vector<Eigen::Vector4f> table;
  std::vector<float> points;
  std::array<bool, kDefines.size()> used{};
  for (const Light& light : lights) {
    const auto kind = static_cast<std::size_t>(played_kind(light));
    used.at(kind) = true;
    const std::vector<Vec2f> samples = light_samples(light, area_samples);
    const std::size_t first_point = points.size() / 2;
    table.push_back(texel(light.position, static_cast<float>(kind)));
    table.push_back(texel(light.direction, light.radius));
    table.push_back(texel(light.intensity, std::cos(light.inner_angle)));
    table.push_back(texel(light.edge_u, std::cos(light.outer_angle)));
    table.push_back(texel(light.edge_v, 0.0F));
    table.emplace_back(static_cast<float>(first_point), static_cast<float>(samples.size()), 0.0F,
                       0.0F);
    for (const Vec2f& uv : samples) points.insert(points.end(), {uv.x(), uv.y()});
  }
  for (std::size_t k = 0; k < used.size(); ++k) {
    if (used[k]) defines_ += kDefines[k];
  }
  table_ = vec4_texels(table);
  points_ = texels(GL_RG32F, 8, points);
}

void LightTable::bind() const {
  table_.read_at(0);
  points_.read_at(1);
}

}  // namespace prt::gl
