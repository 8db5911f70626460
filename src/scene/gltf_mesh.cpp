#include "scene/gltf_mesh.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "scene/gltf_accessor.h"

namespace prt::gltf {
namespace {

using Corners = std::array<std::uint32_t, 3>;

/// A mesh this far out is a mistake, and squares of its coordinates overflow float.
constexpr double kMaxCoordinate = 1e15;
/// Bounds memory: instances cost a file next to nothing.
constexpr std::uint64_t kMaxTriangles = std::uint64_t{1} << 26;
/// A triangle is flat when its height is within the rounding of its float coordinates.
constexpr double kFlat = 0x1p-23;

Eigen::Vector3d vector3(const Accessor& accessor, std::size_t element) {
  return {accessor.real(element, 0), accessor.real(element, 1), accessor.real(element, 2)};
}

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

/// One primitive of one node on its way into the scene.
struct MeshLoader::Primitive {
  const tinygltf::Primitive& from;
  Value json;  ///< the same, for error messages
  Accessor positions;
  std::optional<Accessor> normals;
  std::optional<Accessor> uvs;
  std::uint32_t material = kNone;
  std::uint32_t surface = kNone;
  Eigen::Matrix4d to_world;
  std::vector<Corners> triangles;  ///< vertices of the file, counter-clockwise seen from the front

  [[nodiscard]] Eigen::Vector3d exact_position(std::uint32_t vertex) const {
    return to_world.topLeftCorner<3, 3>() * vector3(positions, vertex) +
           to_world.topRightCorner<3, 1>();
  }
  [[nodiscard]] Vec3f position(std::uint32_t vertex) const {
    return exact_position(vertex).cast<float>();
  }

  std::optional<Accessor> attribute(const Document& document, const std::string& name,
                                    unsigned components) const {
    const auto found = from.attributes.find(name);
    if (found == from.attributes.end()) return std::nullopt;
    Accessor accessor(document, static_cast<std::uint32_t>(found->second));
    const auto where = [&] { return json["attributes"][name.c_str()]; };
    if (accessor.components() != components ||
        accessor.component_type() == ComponentType::kUnsignedInt) {
      where().fail(fmt::format("its accessor should hold {} real numbers per vertex", components));
    }
    if (accessor.count() != positions.count()) {
      where().fail(
          fmt::format("{} vertices have {} elements", positions.count(), accessor.count()));
    }
    return accessor;
  }

  /// Fills `triangles`; mirrored transforms turn the winding (section 3.7.4).
  void read_triangles(const Document& document, bool mirrored) {
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

  /// Vertices in use, increasing.
  [[nodiscard]] std::vector<std::uint32_t> used_vertices() const {
    std::vector<std::uint32_t> used;
    used.reserve(3 * triangles.size());
    for (const Corners& corners : triangles)
      used.insert(used.end(), corners.begin(), corners.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    return used;
  }
};

void MeshLoader::add(const WorldNode& node) {
  skinned_ += node.node->skin >= 0 ? 1 : 0;
  const auto index = static_cast<std::size_t>(node.node->mesh);
  const tinygltf::Mesh& mesh = document_.model().meshes[index];
  const std::vector<Value> json = document_.root().element("meshes", index).list("primitives");
  // tinygltf silently leaves out a primitive that it cannot read.
  if (mesh.primitives.size() != json.size()) {
    fail(document_.name(), fmt::format("tinygltf cannot read all primitives of mesh {}", index));
  }
  for (std::size_t i = 0; i < json.size(); ++i) {
    const tinygltf::Primitive& primitive = mesh.primitives[i];
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES || !primitive.attributes.contains("POSITION")) {
      ++scene_.repairs.skipped_primitives;
    } else {
      add_primitive(node, primitive, json[i]);
    }
  }
}

void MeshLoader::add_primitive(const WorldNode& node, const tinygltf::Primitive& from,
                               const Value& json) {
  Primitive primitive{
      from,
      json,
      Accessor(document_, static_cast<std::uint32_t>(from.attributes.at("POSITION"))),
      {},
      {},
      kNone,
      surfaces_++,
      node.to_world,
      {}};
  static_cast<void>(primitive.attribute(document_, "POSITION", 3));
  primitive.normals = primitive.attribute(document_, "NORMAL", 3);
  TextureCoordinates coordinates;
  if (from.material >= 0) {
    primitive.material = static_cast<std::uint32_t>(from.material);
    coordinates = coordinates_[primitive.material];
  } else {
    primitive.material = default_material();
  }
  primitive.uvs = primitive.attribute(document_, fmt::format("TEXCOORD_{}", coordinates.set), 2);
  morphed_ += from.targets.empty() ? 0 : 1;
  coloured_ += from.attributes.contains("COLOR_0") ? 1 : 0;
  primitive.read_triangles(document_, node.linear().determinant() < 0.0);
  keep_sound_triangles(primitive);
  if (scene_.triangles.size() + primitive.triangles.size() > kMaxTriangles) {
    json.fail(fmt::format("the scene has more than {} triangles", kMaxTriangles));
  }
  if (primitive.normals) {
    emit_shared(primitive, node);
  } else {
    ++scene_.repairs.missing_normals;
    emit_flat(primitive);
  }
}

void MeshLoader::keep_sound_triangles(Primitive& primitive) {
  const auto unsound = [&](const Corners& corners) {
    std::array<Vec3f, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d exact = primitive.exact_position(corners[k]);
      if (!exact.allFinite()) {
        ++scene_.repairs.non_finite_triangles;
        return true;
      }
      if (exact.cwiseAbs().maxCoeff() > kMaxCoordinate) {
        primitive.json["attributes"]["POSITION"].fail(
            fmt::format("vertex {} lies beyond {} m; check its values and the node's transform",
                        corners[k], kMaxCoordinate));
      }
      p[k] = exact.cast<float>();
    }
    if (!is_degenerate(p)) return false;
    ++scene_.repairs.degenerate_triangles;
    return true;
  };
  std::erase_if(primitive.triangles, unsound);
}

void MeshLoader::emit_shared(const Primitive& primitive, const WorldNode& node) {
  const std::vector<std::uint32_t> used = primitive.used_vertices();
  const auto base = static_cast<std::uint32_t>(scene_.positions.size());
  for (const std::uint32_t vertex : used) {
    scene_.positions.push_back(primitive.position(vertex));
    scene_.uvs.push_back(texture_coordinate(primitive, vertex));
  }
  std::vector<Vec3d> geometric(used.size(), Vec3d::Zero());
  for (const Corners& corners : primitive.triangles) {
    Triangle triangle{{}, primitive.material, primitive.surface};
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
    Vec3d normal = to_world * vector3(*primitive.normals, used[i]);
    if (!normal.allFinite() || !(normal.stableNorm() > 0.0)) {
      ++scene_.repairs.bad_normals;
      normal = geometric[i].stableNorm() > 0.0 ? geometric[i] : Vec3d(Vec3d::UnitY());
    }
    scene_.normals.push_back(normal.stableNormalized().cast<float>());
  }
}

void MeshLoader::emit_flat(const Primitive& primitive) {
  for (const Corners& corners : primitive.triangles) {
    const auto first = static_cast<std::uint32_t>(scene_.positions.size());
    for (const std::uint32_t vertex : corners) {
      scene_.positions.push_back(primitive.position(vertex));
      scene_.uvs.push_back(texture_coordinate(primitive, vertex));
    }
    scene_.triangles.push_back(
        {{first, first + 1, first + 2}, primitive.material, primitive.surface});
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

Vec2f MeshLoader::texture_coordinate(const Primitive& primitive, std::uint32_t vertex) {
  if (!primitive.uvs) return Vec2f::Zero();
  Eigen::Vector2d uv(primitive.uvs->real(vertex, 0), primitive.uvs->real(vertex, 1));
  if (primitive.material < coordinates_.size()) {
    uv = coordinates_[primitive.material].transform * uv;
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
