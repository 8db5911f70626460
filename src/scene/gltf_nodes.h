// The node tree of a glTF file, flattened. Internal to scene/.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/types.h"
#include "scene/gltf_document.h"

namespace tinygltf {
class Node;
}

namespace prt::gltf {

struct WorldNode {
  const tinygltf::Node* node;
  Value json;                ///< the same node, for error messages
  Eigen::Matrix4d to_world;  ///< affine; to the world's axes about the origin that was asked for

  [[nodiscard]] Eigen::Matrix3d linear() const { return to_world.topLeftCorner<3, 3>(); }
  /// True if the transform is not invertible or not finite: it flattens geometry.
  [[nodiscard]] bool singular() const;
};

/// The nodes of the default scene (else the first, else all roots), each after its parent, children
/// in the file's order. `origin` (m, world) becomes the origin of their transforms: it is taken
/// from the roots, where a translation by as much leaves exactly nothing.
std::vector<WorldNode> world_nodes(const Document& document, const Vec3d& origin = Vec3d::Zero());

}  // namespace prt::gltf
