// Small scenes with closed-form answers, made in memory.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "scene/scene.h"

namespace prt::test {

/// Adds a material of this albedo and returns its number.
inline std::uint32_t add_material(Scene& scene, const Vec3f& albedo) {
  Material material;
  material.base_color = albedo;
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

inline void add_triangle(Scene& scene, const Vec3f& a, const Vec3f& b, const Vec3f& c,
                         std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(scene.positions.size());
  const Vec3f normal = (b - a).cross(c - a).normalized();
  for (const Vec3f& p : {a, b, c}) {
    scene.positions.push_back(p);
    scene.normals.push_back(normal);
    scene.uvs.emplace_back(0.0F, 0.0F);
  }
  scene.triangles.push_back({{first, first + 1, first + 2}, material, 0});
}

/// The parallelogram corner, corner+u, corner+u+v, corner+v; front side towards u × v.
inline void add_quad(Scene& scene, const Vec3f& corner, const Vec3f& u, const Vec3f& v,
                     std::uint32_t material) {
  add_triangle(scene, corner, corner + u, corner + u + v, material);
  add_triangle(scene, corner, corner + u + v, corner + v, material);
}

/// The six sides of a box, front sides inwards.
inline void add_box(Scene& scene, const Vec3f& low, const Vec3f& high, std::uint32_t material) {
  const Vec3f size = high - low;
  const Vec3f x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  add_quad(scene, low, y, z, material);
  add_quad(scene, low, z, x, material);
  add_quad(scene, low, x, y, material);
  add_quad(scene, high, -z, -y, material);
  add_quad(scene, high, -x, -z, material);
  add_quad(scene, high, -y, -x, material);
}

/// Unit sphere of 20 · 4^levels triangles around the origin, corners on the sphere.
inline void add_icosphere(Scene& scene, int levels, std::uint32_t material) {
  const float g = 0.5F * (1.0F + std::sqrt(5.0F));
  const std::array<Vec3f, 12> corner = {Vec3f(-1, g, 0),  Vec3f(1, g, 0),   Vec3f(-1, -g, 0),
                                        Vec3f(1, -g, 0),  Vec3f(0, -1, g),  Vec3f(0, 1, g),
                                        Vec3f(0, -1, -g), Vec3f(0, 1, -g),  Vec3f(g, 0, -1),
                                        Vec3f(g, 0, 1),   Vec3f(-g, 0, -1), Vec3f(-g, 0, 1)};
  constexpr int kFaces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  std::vector<std::array<Vec3f, 3>> faces;
  for (const auto& f : kFaces) {
    faces.push_back(
        {corner[f[0]].normalized(), corner[f[1]].normalized(), corner[f[2]].normalized()});
  }
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<Vec3f, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Vec3f ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  for (const auto& [a, b, c] : faces) add_triangle(scene, a, b, c, material);
}

/// Sets the bounds; call it once all triangles are there.
inline void finish(Scene& scene) {
  scene.bounds_min = Vec3f::Constant(kInfinity);
  scene.bounds_max = Vec3f::Constant(-kInfinity);
  for (const Vec3f& p : scene.positions) {
    scene.bounds_min = scene.bounds_min.cwiseMin(p);
    scene.bounds_max = scene.bounds_max.cwiseMax(p);
  }
}

}  // namespace prt::test
