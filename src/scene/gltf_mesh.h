// Meshes of a glTF file as triangles about Scene::origin. Internal to scene/.
#pragma once

#include <vector>

#include "scene/gltf_document.h"
#include "scene/gltf_material.h"
#include "scene/gltf_nodes.h"
#include "scene/gltf_primitive.h"
#include "scene/scene.h"

namespace prt::gltf {

/// Appends the mesh of a node to a scene, primitive by primitive; every triangle primitive becomes
/// one surface. Keeps the counts of scene.repairs. What measure_extent() refuses never comes here.
class MeshLoader {
 public:
  MeshLoader(const Document& document, const std::vector<TextureCoordinates>& coordinates,
             Scene& scene)
      : document_(document), coordinates_(coordinates), scene_(scene) {}

  /// The node must have a mesh.
  void add(const WorldNode& node);
  /// Notes on what was ignored, one line each.
  void add_notes();

 private:
  struct Instance;
  void add_primitive(const WorldNode& node, const MeshPrimitive& given);
  void keep_sound_triangles(Primitive& primitive);
  void emit_shared(const Instance& instance, const WorldNode& node);
  void emit_flat(const Instance& instance);
  std::uint32_t default_material();
  Vec2f texture_coordinate(const Instance& instance, std::uint32_t vertex);

  const Document& document_;
  const std::vector<TextureCoordinates>& coordinates_;
  Scene& scene_;
  std::uint32_t default_material_ = kNone;
  std::uint32_t surfaces_ = 0;
  std::uint64_t skinned_ = 0;
  std::uint64_t morphed_ = 0;
  std::uint64_t coloured_ = 0;
  std::uint64_t bad_coordinates_ = 0;
};

}  // namespace prt::gltf
