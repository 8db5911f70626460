#include "scene/load.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <limits>

#include "scene/gltf_document.h"
#include "scene/gltf_lights.h"
#include "scene/gltf_material.h"
#include "scene/gltf_mesh.h"
#include "scene/gltf_nodes.h"
#include "scene/scene_hash.h"

namespace prt {
namespace {

void set_bounds(Scene& scene) {
  scene.bounds_min = scene.bounds_max = scene.positions.front();
  for (const Vec3f& position : scene.positions) {
    scene.bounds_min = scene.bounds_min.cwiseMin(position);
    scene.bounds_max = scene.bounds_max.cwiseMax(position);
  }
}

/// A note where vertices far from the origin have lost what one would see.
void note_lost_precision(Scene& scene) {
  constexpr float kVisible = 1e-5F;  // of the scene's diagonal
  const float farthest =
      scene.bounds_min.cwiseAbs().cwiseMax(scene.bounds_max.cwiseAbs()).maxCoeff();
  const float spacing = farthest * std::numeric_limits<float>::epsilon();
  if (spacing <= kVisible * scene.diagonal()) return;
  scene.repairs.notes.push_back(fmt::format(
      "coordinates up to {:.1e} m are rounded to {:.1e} m, in a scene of {:.1e} m; move it nearer "
      "to the origin",
      farthest, spacing, scene.diagonal()));
}

}  // namespace

Scene load_scene(const std::filesystem::path& file) {
  const gltf::Document document(file);
  Scene scene;
  const auto coordinates = gltf::load_materials(document, scene);
  const std::vector<gltf::WorldNode> nodes = gltf::world_nodes(document);
  gltf::MeshLoader meshes(document, coordinates, scene);
  for (const gltf::WorldNode& node : nodes) {
    if (node.node->mesh < 0) continue;
    if (node.singular()) {
      ++scene.repairs.singular_transforms;
    } else {
      meshes.add(node);
    }
  }
  meshes.add_notes();
  gltf::load_lights_and_camera(document, nodes, scene);
  if (scene.triangles.empty()) gltf::fail(document.name(), "no triangle is left to bake");
  set_bounds(scene);
  note_lost_precision(scene);
  hash_scene(scene);
  return scene;
}

}  // namespace prt
