// Reads a glTF 2.0 scene (.glb or .gltf).
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace prt {

/// Loads and flattens the default scene of the file: node transforms (mirrored and sheared ones
/// included), instancing, strips and fans, 8/16/32-bit or no indices, made-up normals where
/// missing. The JSON is validated before tinygltf sees it. Degenerate and non-finite triangles are
/// left out and counted in Scene::repairs. Throws UserError: missing, empty, truncated or foreign
/// file, buffer or image URI outside the file's folder, node cycle, index out of range, no triangle
/// left.
Scene load_scene(const std::filesystem::path& file);

}  // namespace prt
