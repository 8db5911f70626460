// Lights and camera of a glTF file. Internal to scene/.
#pragma once

#include <vector>

#include "scene/gltf_document.h"
#include "scene/gltf_nodes.h"
#include "scene/scene.h"

namespace prt::gltf {

/// Appends the lights of KHR_lights_punctual (candela and lux divided by 683 lm/W) and sets the
/// camera to the first that a node of the scene holds.
void load_lights_and_camera(const Document& document, const std::vector<WorldNode>& nodes,
                            Scene& scene);

}  // namespace prt::gltf
