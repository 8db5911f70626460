#include "scene/load.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <optional>

#include "scene/gltf_document.h"
#include "scene/gltf_extent.h"
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

void note_origin(const gltf::Extent& extent, Scene& scene) {
  if (!scene.recentred()) return;
  scene.repairs.notes.push_back(
      fmt::format("its centre lies {:.3g} m from the world's origin, {:.0f} times its size of "
                  "{:.3g} m: positions "
                  "are kept relative to ({}, {}, {})",
                  extent.centre().norm(), extent.centre().norm() / extent.diagonal(),
                  extent.diagonal(), scene.origin.x(), scene.origin.y(), scene.origin.z()));
}

/// A note where the file's own vertices have lost what one would see.
void note_lost_precision(const gltf::Extent& extent, Scene& scene) {
  constexpr double kVisible = 1e-5;  // of the diagonal: a thousandth of a usual sample spacing
  scene.vertex_rounding = extent.vertex_rounding;
  if (extent.vertex_rounding <= kVisible * extent.diagonal()) return;
  scene.repairs.notes.push_back(
      fmt::format("vertices lie {:.3g} m from the origin of their own mesh: positions are good to "
                  "{:.2g} mm, in a scene of {:.3g} m; store them nearer to it and move the node",
                  extent.vertex_distance, 1e3 * extent.vertex_rounding, extent.diagonal()));
}

/// `origin`: the one to take; empty: a fitting one is chosen.
Scene load(const std::filesystem::path& file, const std::optional<Vec3d>& origin) {
  const gltf::Document document(file);
  Scene scene;
  const auto coordinates = gltf::load_materials(document, scene);
  std::vector<gltf::WorldNode> nodes = gltf::world_nodes(document);
  const gltf::Extent extent = gltf::measure_extent(document, nodes);
  scene.origin = origin ? *origin : gltf::choose_origin(extent);
  if (scene.recentred()) nodes = gltf::world_nodes(document, scene.origin);
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
  note_origin(extent, scene);
  note_lost_precision(extent, scene);
  hash_scene(scene);
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& file) { return load(file, std::nullopt); }

Scene load_scene_about(const std::filesystem::path& file, const Vec3d& origin) {
  return load(file, origin);
}

}  // namespace prt
