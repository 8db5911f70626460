// Content hashes of a scene. Internal to scene/.
#pragma once

#include "scene/scene.h"

namespace prt {

/// Fills geometry_hash, materials_hash and lights_hash.
void hash_scene(Scene& scene);

}  // namespace prt
