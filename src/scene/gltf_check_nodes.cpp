#include <fmt/format.h>

#include <algorithm>

#include "base/types.h"
#include "scene/gltf_check.h"

namespace prt::gltf {
namespace {

void check_transform(const Value& node) {
  if (const auto matrix = node.find("matrix")) {
    const std::vector<double> m = matrix->numbers(16);
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
      matrix->fail("its last row must be 0 0 0 1");
    }
  }
  for (const char* key : {"scale", "translation"}) {
    if (const auto vector = node.find(key)) static_cast<void>(vector->numbers(3));
  }
  if (const auto rotation = node.find("rotation")) {
    const std::vector<double> xyzw = rotation->numbers(4);
    if (std::all_of(xyzw.begin(), xyzw.end(), [](double x) { return x * x == 0.0; })) {
      rotation->fail("it is zero, not a unit quaternion");
    }
  }
}

/// The parent of every node; kNone for roots.
std::vector<std::uint32_t> parents(const Value& root) {
  const std::size_t count = root.count_of("nodes");
  std::vector<std::uint32_t> parent(count, kNone);
  for (std::uint32_t node = 0; node < count; ++node) {
    for (const Value& json : root.element("nodes", node).list("children")) {
      const std::uint32_t child = json.index(count, "nodes");
      if (parent[child] != kNone) {
        json.fail(fmt::format("node {} has two parents, {} and {}", child, parent[child], node));
      }
      parent[child] = node;
    }
  }
  return parent;
}

/// With one parent each, a node lies on a cycle or below one if its ancestors never end.
void check_cycles(const Value& root, const std::vector<std::uint32_t>& parent) {
  enum class State : std::uint8_t { kUnknown, kOnPath, kSound };
  std::vector<State> state(parent.size(), State::kUnknown);
  std::vector<std::uint32_t> path;
  for (std::uint32_t first = 0; first < parent.size(); ++first) {
    path.clear();
    std::uint32_t node = first;
    while (node != kNone && state[node] == State::kUnknown) {
      state[node] = State::kOnPath;
      path.push_back(node);
      node = parent[node];
    }
    if (node != kNone && state[node] == State::kOnPath) {
      root.element("nodes", node).fail("the node lies on a cycle");
    }
    for (const std::uint32_t sound : path) state[sound] = State::kSound;
  }
}

void check_scenes(const Value& root, const std::vector<std::uint32_t>& parent) {
  for (const Value& scene : root.list("scenes")) {
    std::vector<bool> listed(parent.size(), false);
    for (const Value& json : scene.list("nodes")) {
      const std::uint32_t node = json.index(parent.size(), "nodes");
      if (parent[node] != kNone) {
        json.fail(fmt::format("node {} is not a root: it has a parent", node));
      }
      if (listed[node]) json.fail(fmt::format("node {} is listed twice", node));
      listed[node] = true;
    }
  }
}

}  // namespace

void check_nodes(const Value& root) {
  const auto lights = extension(root, "KHR_lights_punctual");
  for (const Value& node : root.list("nodes")) {
    check_transform(node);
    check_index(node, "mesh", root, "meshes");
    check_index(node, "camera", root, "cameras");
    check_index(node, "skin", root, "skins");
    if (const auto light = extension(node, "KHR_lights_punctual")) {
      static_cast<void>((*light)["light"].index(lights ? lights->count_of("lights") : 0, "lights"));
    }
  }
  const std::vector<std::uint32_t> parent = parents(root);
  check_cycles(root, parent);
  check_index(root, "scene", root, "scenes");
  check_scenes(root, parent);
}

}  // namespace prt::gltf
