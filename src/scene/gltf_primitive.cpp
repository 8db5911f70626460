#include "scene/gltf_primitive.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace prt::gltf {
namespace {

std::size_t triangle_count(int mode, std::size_t corners) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

/// Places in the index list of a triangle's corners, in glTF's order (section 3.7.2.1).
std::array<std::size_t, 3> corner_places(int mode, std::size_t triangle) {
  const std::size_t i = triangle;
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) return {i, i + 1 + i % 2, i + 2 - i % 2};
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

}  // namespace

Vec3d vector3(const Accessor& accessor, std::size_t element) {
  return {accessor.real(element, 0), accessor.real(element, 1), accessor.real(element, 2)};
}

Primitive::Primitive(const Document& document, const WorldNode& node,
                     const tinygltf::Primitive& primitive, Value where)
    : from(primitive),
      json(std::move(where)),
      positions(document, static_cast<std::uint32_t>(from.attributes.at("POSITION"))),
      to_world(node.to_world) {
  check_attribute(positions, "POSITION", 3);
  // Mirrored transforms turn the winding (section 3.7.4).
  read_triangles(document, node.linear().determinant() < 0.0);
}

void Primitive::check_attribute(const Accessor& accessor, const std::string& name,
                                unsigned components) const {
  const auto where = [&] { return json["attributes"][name.c_str()]; };
  if (accessor.components() != components ||
      accessor.component_type() == ComponentType::kUnsignedInt) {
    where().fail(fmt::format("its accessor should hold {} real numbers per vertex", components));
  }
  if (accessor.count() != positions.count()) {
    where().fail(fmt::format("{} vertices have {} elements", positions.count(), accessor.count()));
  }
}

std::optional<Accessor> Primitive::attribute(const Document& document, const std::string& name,
                                             unsigned components) const {
  const auto found = from.attributes.find(name);
  if (found == from.attributes.end()) return std::nullopt;
  Accessor accessor(document, static_cast<std::uint32_t>(found->second));
  check_attribute(accessor, name, components);
  return accessor;
}

void Primitive::read_triangles(const Document& document, bool mirrored) {
  const int mode = from.mode;
  std::optional<Accessor> indices;
  if (from.indices >= 0) {
    indices.emplace(document, static_cast<std::uint32_t>(from.indices));
    const ComponentType type = indices->component_type();
    if (indices->components() != 1 || type == ComponentType::kFloat ||
        type == ComponentType::kByte || type == ComponentType::kShort) {
      json["indices"].fail("indices should be unsigned integers");
    }
  }
  const std::size_t count = triangle_count(mode, indices ? indices->count() : positions.count());
  if (count > kMaxTriangles) json.fail("it has too many triangles");
  triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    Corners corners{};
    const std::array<std::size_t, 3> places = corner_places(mode, t);
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = indices ? indices->integer(places[k]) : static_cast<std::uint32_t>(places[k]);
      if (corners[k] >= positions.count()) {
        json["indices"].fail(fmt::format("index {} is out of range: there are {} vertices",
                                         corners[k], positions.count()));
      }
    }
    if (mirrored) std::swap(corners[1], corners[2]);
    triangles.push_back(corners);
  }
}

std::vector<std::uint32_t> Primitive::used_vertices() const {
  std::vector<std::uint32_t> used;
  used.reserve(3 * triangles.size());
  for (const Corners& corners : triangles) used.insert(used.end(), corners.begin(), corners.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

bool MeshPrimitive::has_triangles() const {
  return from->mode >= TINYGLTF_MODE_TRIANGLES && from->attributes.contains("POSITION");
}

std::vector<MeshPrimitive> mesh_primitives(const Document& document, const WorldNode& node) {
  const auto index = static_cast<std::size_t>(node.node->mesh);
  const tinygltf::Mesh& mesh = document.model().meshes[index];
  const std::vector<Value> json = document.root().element("meshes", index).list("primitives");
  // tinygltf silently leaves out a primitive that it cannot read.
  if (mesh.primitives.size() != json.size()) {
    fail(document.name(), fmt::format("tinygltf cannot read all primitives of mesh {}", index));
  }
  std::vector<MeshPrimitive> primitives;
  primitives.reserve(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    primitives.push_back({&mesh.primitives[i], json[i]});
  }
  return primitives;
}

}  // namespace prt::gltf
