// A window on a package: camera and lights follow mouse and keys.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "player/environment_light.h"
#include "player/gl/eyes.h"

namespace prt::gl {

struct ViewerSettings {
  std::string title;
  int width = 1024;
  int height = 768;
  int area_samples = 25;
  Show show = Show::kFull;
  std::optional<float> exposure;  ///< none: the first picture's own
  StereoSettings stereo;
  const Environment* environment = nullptr;  ///< null: none
  const EnvironmentLight* sky = nullptr;     ///< of it
  std::string pictures = "prt_play";         ///< path that screenshots' names begin with
};

/// What the user has set up.
struct Stage {
  std::vector<Light> lights;
  SceneCamera camera;
  float exposure = 1.0F;
  float turn = 0.0F;        ///< of the environment, degrees
  float reflection = 0.0F;  ///< share of it that surfaces mirror
};

/// Shows the package until the window is closed, and returns what was set up last. `say` is called
/// with one line for each picture that is written. Throws UserError where there is no display or no
/// OpenGL 4.3.
///
/// Left drag: the light, with shift nearer and farther; where there is none, the environment turns.
/// Right drag: round the target, or, walking, the view. Wheel: nearer. W A S D Q E: walk. P:
/// screenshot. T: turntable. F1: the panel. Escape: the end.
Stage run_viewer(const Package& package, const Stage& start, const ViewerSettings& settings,
                 const std::function<void(const std::string&)>& say);

}  // namespace prt::gl
