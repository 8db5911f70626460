#include "jobs/task.h"

#include <string>

namespace prt {

Digest task_key(const TaskSpec& task, const std::vector<Digest>& input_contents,
                const SceneHashes& scene) {
  Hasher hasher;
  // nlohmann::json objects are sorted by name: dump() is canonical.
  hasher.add(task.kind).add(std::to_string(task.version)).add(task.parameters.dump());
  for (const Digest& d : input_contents) hasher.add(d.hex());
  if (task.scene_parts & kGeometry) hasher.add("geometry").add(scene.geometry.hex());
  if (task.scene_parts & kMaterials) hasher.add("materials").add(scene.materials.hex());
  if (task.scene_parts & kLights) hasher.add("lights").add(scene.lights.hex());
  return hasher.digest();
}

}  // namespace prt
