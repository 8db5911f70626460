// One triangle primitive of a mesh under a node, before it is rounded to float. Internal to scene/.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/types.h"
#include "scene/gltf_accessor.h"
#include "scene/gltf_nodes.h"

namespace tinygltf {
struct Primitive;
}

namespace prt::gltf {

/// Bounds memory: instances cost a file next to nothing.
inline constexpr std::uint64_t kMaxTriangles = std::uint64_t{1} << 26;

/// Three components of an element.
Vec3d vector3(const Accessor& accessor, std::size_t element);

struct Primitive {
  using Corners = std::array<std::uint32_t, 3>;

  /// Reads and checks positions and triangles; `from` must have both (has_triangles).
  Primitive(const Document& document, const WorldNode& node, const tinygltf::Primitive& from,
            Value json);

  const tinygltf::Primitive& from;
  Value json;  ///< the same, for error messages
  Accessor positions;
  Eigen::Matrix4d to_world;
  std::vector<Corners> triangles;  ///< vertices of the file, counter-clockwise seen from the front

  [[nodiscard]] Vec3d position(std::uint32_t vertex) const {
    return to_world.topLeftCorner<3, 3>() * vector3(positions, vertex) +
           to_world.topRightCorner<3, 1>();
  }
  /// Another attribute of the vertices, where the primitive has it.
  [[nodiscard]] std::optional<Accessor> attribute(const Document& document, const std::string& name,
                                                  unsigned components) const;
  /// Vertices in use, increasing.
  [[nodiscard]] std::vector<std::uint32_t> used_vertices() const;

 private:
  void check_attribute(const Accessor& accessor, const std::string& name,
                       unsigned components) const;
  void read_triangles(const Document& document, bool mirrored);
};

/// A mesh's primitive as the file has it, sound or not.
struct MeshPrimitive {
  const tinygltf::Primitive* from;
  Value json;  ///< the same, for error messages
  /// False for points, lines, and where there are no positions.
  [[nodiscard]] bool has_triangles() const;
};

/// The primitives of the node's mesh, in the file's order; the node must have one.
std::vector<MeshPrimitive> mesh_primitives(const Document& document, const WorldNode& node);

}  // namespace prt::gltf
