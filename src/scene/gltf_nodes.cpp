#include "scene/gltf_nodes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "base/types.h"

namespace prt::gltf {
namespace {

/// Relative to the product of the column lengths, which is |det| when the columns are orthogonal.
constexpr double kSingular = 1e-9;

Eigen::Matrix4d local_transform(const Value& node) {
  Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
  if (const std::optional<Value> matrix = node.find("matrix")) {
    const std::vector<double> numbers = matrix->numbers(16);
    transform = Eigen::Map<const Eigen::Matrix4d>(numbers.data());
    if (transform.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) {
      matrix->fail("its last row must be 0 0 0 1");
    }
    return transform;
  }
  const auto vector = [&](const char* key, Eigen::Vector3d fallback) -> Eigen::Vector3d {
    const std::optional<Value> member = node.find(key);
    if (!member) return fallback;
    return Eigen::Map<const Eigen::Vector3d>(member->numbers(3).data());
  };
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (const std::optional<Value> member = node.find("rotation")) {
    const std::vector<double> xyzw = member->numbers(4);
    Eigen::Quaterniond quaternion(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
    if (quaternion.norm() == 0.0) member->fail("it is zero, not a unit quaternion");
    rotation = quaternion.normalized().toRotationMatrix();
  }
  transform.topLeftCorner<3, 3>() =
      rotation * vector("scale", Eigen::Vector3d::Ones()).asDiagonal();
  transform.topRightCorner<3, 1>() = vector("translation", Eigen::Vector3d::Zero());
  return transform;
}

/// Children of every node, and that each node has one parent at most and is not its own ancestor.
class Tree {
 public:
  explicit Tree(const Value& root) : count_(root.count_of("nodes")), parent_(count_, kNone) {
    children_.resize(count_);
    for (std::uint32_t node = 0; node < count_; ++node) {
      for (const Value& json : root.element("nodes", node).list("children")) {
        const std::uint32_t child = json.index(count_, "nodes");
        if (parent_[child] != kNone) {
          json.fail(fmt::format("node {} has two parents, {} and {}", child, parent_[child], node));
        }
        parent_[child] = node;
        children_[node].push_back(child);
      }
    }
    check_cycles(root);
  }

  [[nodiscard]] const std::vector<std::uint32_t>& children(std::uint32_t node) const {
    return children_[node];
  }
  [[nodiscard]] bool is_root(std::uint32_t node) const { return parent_[node] == kNone; }
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(count_); }

 private:
  /// With one parent each, nodes that no root reaches go round in a cycle.
  void check_cycles(const Value& root) const {
    std::vector<std::uint32_t> reached;
    for (std::uint32_t node = 0; node < count_; ++node) {
      if (is_root(node)) reached.push_back(node);
    }
    std::vector<bool> seen(count_, false);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      seen[reached[i]] = true;
      const auto& next = children_[reached[i]];
      reached.insert(reached.end(), next.begin(), next.end());
    }
    const auto lost = std::find(seen.begin(), seen.end(), false);
    if (lost != seen.end()) {
      const auto node = static_cast<std::size_t>(lost - seen.begin());
      root.element("nodes", node).fail("the node lies on a cycle or below one");
    }
  }

  std::size_t count_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::vector<std::uint32_t>> children_;
};

std::vector<std::uint32_t> scene_roots(const Value& root, const Tree& tree) {
  std::vector<std::uint32_t> roots;
  const std::size_t scenes = root.count_of("scenes");
  const std::optional<Value> chosen = root.find("scene");
  if (scenes == 0 && !chosen) {
    for (std::uint32_t node = 0; node < tree.count(); ++node) {
      if (tree.is_root(node)) roots.push_back(node);
    }
    return roots;
  }
  const std::uint32_t scene = chosen ? chosen->index(scenes, "scenes") : 0;
  std::vector<bool> listed(tree.count(), false);
  for (const Value& json : root.element("scenes", scene).list("nodes")) {
    const std::uint32_t node = json.index(tree.count(), "nodes");
    if (!tree.is_root(node)) json.fail(fmt::format("node {} is not a root: it has a parent", node));
    if (listed[node]) json.fail(fmt::format("node {} is listed twice", node));
    listed[node] = true;
    roots.push_back(node);
  }
  return roots;
}

}  // namespace

bool WorldNode::singular() const {
  const Eigen::Matrix3d m = linear();
  const double scale = m.col(0).norm() * m.col(1).norm() * m.col(2).norm();
  return !to_world.allFinite() || !(std::abs(m.determinant()) > kSingular * scale);
}

std::vector<WorldNode> world_nodes(const Document& document) {
  const Value root = document.root();
  const Tree tree(root);
  struct Pending {
    std::uint32_t node;
    Eigen::Matrix4d parent_to_world;
  };
  std::vector<Pending> stack;
  const std::vector<std::uint32_t> roots = scene_roots(root, tree);
  for (auto node = roots.rbegin(); node != roots.rend(); ++node) {
    stack.push_back({*node, Eigen::Matrix4d::Identity()});
  }
  std::vector<WorldNode> nodes;
  while (!stack.empty()) {
    const Pending next = stack.back();
    stack.pop_back();
    const Value json = root.element("nodes", next.node);
    nodes.push_back({json, next.parent_to_world * local_transform(json)});
    const auto& children = tree.children(next.node);
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      stack.push_back({*child, nodes.back().to_world});
    }
  }
  return nodes;
}

}  // namespace prt::gltf
