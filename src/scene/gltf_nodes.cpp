#include "scene/gltf_nodes.h"

#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace prt::gltf {
namespace {

/// Relative to the product of the column lengths, which is |det| when the columns are orthogonal.
constexpr double kSingular = 1e-9;

Eigen::Matrix4d local_transform(const tinygltf::Node& node) {
  if (!node.matrix.empty()) return Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (!node.translation.empty()) {
    transform.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
  }
  if (!node.rotation.empty()) {
    const std::vector<double>& xyzw = node.rotation;
    transform.rotate(Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).normalized());
  }
  if (!node.scale.empty()) transform.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()));
  return transform.matrix();
}

std::vector<int> scene_roots(const tinygltf::Model& model) {
  if (!model.scenes.empty()) {
    return model.scenes[static_cast<std::size_t>(std::max(model.defaultScene, 0))].nodes;
  }
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes) {
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  }
  std::vector<int> roots;
  for (std::size_t node = 0; node < is_child.size(); ++node) {
    if (!is_child[node]) roots.push_back(static_cast<int>(node));
  }
  return roots;
}

}  // namespace

bool WorldNode::singular() const {
  const Eigen::Matrix3d m = linear();
  const double scale = m.col(0).norm() * m.col(1).norm() * m.col(2).norm();
  return !to_world.allFinite() || !(std::abs(m.determinant()) > kSingular * scale);
}

std::vector<WorldNode> world_nodes(const Document& document, const Vec3d& origin) {
  const tinygltf::Model& model = document.model();
  struct Pending {
    int node;
    Eigen::Matrix4d parent_to_world;
  };
  Eigen::Matrix4d about_origin = Eigen::Matrix4d::Identity();
  about_origin.topRightCorner<3, 1>() = -origin;
  std::vector<Pending> stack;
  const std::vector<int> roots = scene_roots(model);
  for (auto node = roots.rbegin(); node != roots.rend(); ++node) {
    stack.push_back({*node, about_origin});
  }
  std::vector<WorldNode> nodes;
  while (!stack.empty()) {
    const Pending next = stack.back();
    stack.pop_back();
    const auto index = static_cast<std::size_t>(next.node);
    const tinygltf::Node& node = model.nodes[index];
    nodes.push_back({&node, document.root().element("nodes", index),
                     next.parent_to_world * local_transform(node)});
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
      stack.push_back({*child, nodes.back().to_world});
    }
  }
  return nodes;
}

}  // namespace prt::gltf
