// The scene as plain glTF, so that any viewer shows it. Internal to package/.
#pragma once

#include <cstdint>
#include <vector>

#include "package/gltf_writer.h"
#include "scene/scene.h"

namespace prt {

/// Writes the triangles as one mesh with a primitive per material, and materials, textures, camera
/// and lights (candela and lux); all below a node that stands at Scene::origin, where that is not
/// the world's. Returns the new number of each of the scene's triangles:
/// its place in the file, and so in the Scene that load_scene makes of it.
std::vector<std::uint32_t> export_scene(const Scene& scene, GltfWriter& writer);

}  // namespace prt
