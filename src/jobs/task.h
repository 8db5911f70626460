// What a task is: a pure function of its parameters, its inputs and the part of the scene it reads.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/hash.h"

namespace prt {

/// Which of the scene's three hashes go into a task's key. A task may read only what it names.
enum ScenePart : unsigned { kNoScene = 0, kGeometry = 1, kMaterials = 2, kLights = 4 };

/// One unit of work: 0.1 to 30 s on one core. Its result is one artifact.
struct TaskSpec {
  std::string id;    ///< unique in the bake and stable between runs: "rays/0007"
  std::string kind;  ///< "rays": what code runs it; also the stage it is shown under
  int version = 1;   ///< of that code; raised whenever its bytes change
  nlohmann::json parameters =
      nlohmann::json::object();     ///< all that the result depends on beside inputs
  std::vector<std::string> inputs;  ///< task ids, in the order the code expects
  unsigned scene_parts = kNoScene;
  double cost = 1.0;  ///< rough seconds on one core: who begins the longest chain goes first
  /// Tasks of one place read much in common and run on one rank as long as nobody would wait;
  /// empty: anywhere. No result depends on it, and no KEY.
  std::string place = {};
};

/// KEY of design §4: hash of kind, version, canonical parameters, inputs' content hashes, and the
/// hashes of the named scene parts.
struct SceneHashes {
  Digest geometry;
  Digest materials;
  Digest lights;
};
Digest task_key(const TaskSpec& task, const std::vector<Digest>& input_contents,
                const SceneHashes& scene);

}  // namespace prt
