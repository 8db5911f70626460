// prt_play --backend gl.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "apps/prt_play_command.h"
#include "package/package.h"
#include "player/environment_light.h"
#include "scene/light.h"

namespace prt {

/// What is played, the command line's choices filled in.
struct GlScene {
  const Package& package;
  const std::vector<Light>& lights;
  const Environment* environment;  ///< null: none
  const EnvironmentLight* sky;     ///< of it
  const SceneCamera& camera;
  double start;  ///< of the program, on steady_seconds()
};

/// Bench and picture without a window, or, where neither is asked for, a window. Adds to `report`.
void play_gl(const PlayCommand& command, const GlScene& scene, nlohmann::json& report);

}  // namespace prt
