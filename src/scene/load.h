// Reads a glTF 2.0 scene (.glb or .gltf).
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace prt {

/// Beyond it a vertex is a mistake, and squares of coordinates overflow float. Metres.
inline constexpr double kFarthestCoordinate = 1e15;

/// Loads and flattens the default scene of the file: node transforms (mirrored and sheared ones
/// included), instancing, strips and fans, 8/16/32-bit or no indices, made-up normals where
/// missing. The JSON is validated before tinygltf sees it. Degenerate and non-finite triangles are
/// left out and counted in Scene::repairs. A scene far from the world's origin gets an origin of
/// its own (Scene::origin), before anything becomes float. Throws UserError: missing, empty,
/// truncated or foreign file, buffer or image URI outside the file's folder, node cycle, index out
/// of range, vertex beyond kFarthestCoordinate, no triangle left.
Scene load_scene(const std::filesystem::path& file);

/// The same about a given origin (m, world; no coordinate beyond kFarthestCoordinate), for a
/// package whose samples are relative to it.
Scene load_scene_about(const std::filesystem::path& file, const Vec3d& origin);

}  // namespace prt
