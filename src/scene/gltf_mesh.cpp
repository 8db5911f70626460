#include "scene/gltf_mesh.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace prt::gltf {
namespace {

using Corners = Primitive::Corners;

/// A triangle is flat when its height is within the rounding of its float coordinates.
constexpr double kFlat = 0x1p-23;

bool is_degenerate(const std::array<Vec3f, 3>& p) {
  const Vec3d a = p[0].cast<double>();
  const Vec3d b = p[1].cast<double>();
  const Vec3d c = p[2].cast<double>();
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const double extent =
      std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
  return !((b - a).cross(c - a).norm() > kFlat * extent * longest);
}

}  // namespace

/// A primitive on its way into the scene.
struct MeshLoader::Instance {
  Primitive primitive;
  std::optional<Accessor> normals;
  std::optional<Accessor> uvs;
  std::uint32_t material = kNone;
  std::uint32_t surface = kNone;
};

void MeshLoader::add(const WorldNode& node) {
  skinned_ += node.node->skin >= 0 ? 1 : 0;
  for (const MeshPrimitive& primitive : mesh_primitives(document_, node)) {
    if (primitive.has_triangles()) {
      add_primitive(node, primitive);
    } else {
      ++scene_.repairs.skipped_primitives;
    }
  }
}

void MeshLoader::add_primitive(const WorldNode& node, const MeshPrimitive& given) {
  const tinygltf::Primitive& from = *given.from;
  Instance instance{Primitive(document_, node, from, given.json), {}, {}, kNone, surfaces_++};
  Primitive& primitive = instance.primitive;
  instance.normals = primitive.attribute(document_, "NORMAL", 3);
  TextureCoordinates coordinates;
  if (from.material >= 0) {
    instance.material = static_cast<std::uint32_t>(from.material);
    coordinates = coordinates_[instance.material];
  } else {
    instance.material = default_material();
  }
  instance.uvs = primitive.attribute(document_, fmt::format("TEXCOORD_{}", coordinates.set), 2);
  morphed_ += from.targets.empty() ? 0 : 1;
  coloured_ += from.attributes.contains("COLOR_0") ? 1 : 0;
  keep_sound_triangles(primitive);
  if (instance.normals) {
    emit_shared(instance, node);
  } else {
    ++scene_.repairs.missing_normals;
    emit_flat(instance);
  }
}

void MeshLoader::keep_sound_triangles(Primitive& primitive) {
  const auto unsound = [&](const Corners& corners) {
    std::array<Vec3f, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d exact = primitive.position(corners[k]);
      if (!exact.allFinite()) {
        ++scene_.repairs.non_finite_triangles;
        return true;
      }
      p[k] = exact.cast<float>();
    }
    if (!is_degenerate(p)) return false;
    ++scene_.repairs.degenerate_triangles;
    return true;
  };
  std::erase_if(primitive.triangles, unsound);
}

void MeshLoader::emit_shared(const Instance& instance, const WorldNode& node) {
  const Primitive& primitive = instance.primitive;
  const std::vector<std::uint32_t> used = primitive.used_vertices();
  const auto base = static_cast<std::uint32_t>(scene_.positions.size());
  for (const std::uint32_t vertex : used) {
    scene_.positions.push_back(primitive.position(vertex).cast<float>());
    scene_.uvs.push_back(texture_coordinate(instance, vertex));
  }
  std::vector<Vec3d> geometric(used.size(), Vec3d::Zero());
  for (const Corners& corners : primitive.triangles) {
    Triangle triangle{{}, instance.material, instance.surface};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = std::lower_bound(used.begin(), used.end(), corners[k]) - used.begin();
      triangle.vertex[k] = base + static_cast<std::uint32_t>(place);
    }
    const Vec3d a = scene_.positions[triangle.vertex[0]].cast<double>();
    const Vec3d doubled_area = (scene_.positions[triangle.vertex[1]].cast<double>() - a)
                                   .cross(scene_.positions[triangle.vertex[2]].cast<double>() - a);
    for (const std::uint32_t vertex : triangle.vertex) geometric[vertex - base] += doubled_area;
    scene_.triangles.push_back(triangle);
  }
  // Inverse transpose, up to a positive factor: its columns are cross products, negated if
  // mirrored.
  const Eigen::Matrix3d m = node.linear() / node.linear().cwiseAbs().maxCoeff();
  Eigen::Matrix3d to_world;
  to_world << m.col(1).cross(m.col(2)), m.col(2).cross(m.col(0)), m.col(0).cross(m.col(1));
  if (m.determinant() < 0.0) to_world = -to_world;
  for (std::size_t i = 0; i < used.size(); ++i) {
    Vec3d normal = to_world * vector3(*instance.normals, used[i]);
    if (!normal.allFinite() || !(normal.stableNorm() > 0.0)) {
      ++scene_.repairs.bad_normals;
      normal = geometric[i].stableNorm() > 0.0 ? geometric[i] : Vec3d(Vec3d::UnitY());
    }
    scene_.normals.push_back(normal.stableNormalized().cast<float>());
  }
}

void MeshLoader::emit_flat(const Instance& instance) {
  for (const Corners& corners : instance.primitive.triangles) {
    const auto first = static_cast<std::uint32_t>(scene_.positions.size());
    for (const std::uint32_t vertex : corners) {
      scene_.positions.push_back(instance.primitive.position(vertex).cast<float>());
      scene_.uvs.push_back(texture_coordinate(instance, vertex));
    }
    scene_.triangles.push_back(
        {{first, first + 1, first + 2}, instance.material, instance.surface});
    const Vec3f normal =
        triangle_normal(scene_, static_cast<std::uint32_t>(scene_.triangles.size() - 1));
    scene_.normals.insert(scene_.normals.end(), 3, normal);
  }
}

std::uint32_t MeshLoader::default_material() {
  if (default_material_ == kNone) {
    default_material_ = static_cast<std::uint32_t>(scene_.materials.size());
    scene_.materials.emplace_back().name = "default";
  }
  return default_material_;
}

Vec2f MeshLoader::texture_coordinate(const Instance& instance, std::uint32_t vertex) {
  if (!instance.uvs) return Vec2f::Zero();
  Eigen::Vector2d uv(instance.uvs->real(vertex, 0), instance.uvs->real(vertex, 1));
  if (instance.material < coordinates_.size()) {
    uv = coordinates_[instance.material].transform * uv;
  }
  const Vec2f result = uv.cast<float>();
  if (result.allFinite()) return result;
  ++bad_coordinates_;
  return Vec2f::Zero();
}

void MeshLoader::add_notes() {
  const RepairReport& counts = scene_.repairs;
  const auto note = [&](std::uint64_t count, std::string_view what) {
    if (count > 0) scene_.repairs.notes.push_back(fmt::format("{} {}", count, what));
  };
  note(counts.degenerate_triangles, "triangles without area left out");
  note(counts.non_finite_triangles, "triangles with non-finite vertices left out");
  note(counts.singular_transforms, "nodes left out: their transforms flatten geometry");
  note(counts.skipped_primitives, "primitives left out: points, lines, or without positions");
  note(counts.missing_normals, "primitives without normals: flat ones made");
  note(counts.bad_normals, "vertex normals replaced: zero or not finite");
  note(bad_coordinates_, "texture coordinates set to 0: not finite");
  note(skinned_, "skinned meshes taken in their bind pose");
  note(morphed_, "primitives taken without their morph targets");
  note(coloured_, "primitives' vertex colours ignored");
}

}  // namespace prt::gltf
