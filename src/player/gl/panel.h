// The panel of the viewer: what can be set and what frames cost. Internal to player/gl.
#pragma once

#include <deque>

#include "player/gl/viewer.h"

namespace prt::gl {

/// Everything that the panel shows and changes.
struct PanelState {
  Stage stage;
  std::size_t selected = 0;  ///< light
  Show show = Show::kFull;
  StereoSettings stereo;
  bool walking = false;
  bool visible = true;
  bool has_lights = true;  ///< that can be added
  bool has_environment = false;
  bool auto_exposure = false;    ///< wanted for the next picture
  bool screenshot = false;       ///< wanted
  bool turntable = false;        ///< wanted
  float scene_size = 1.0F;       ///< diagonal, m
  std::deque<PassTimes> frames;  ///< the last ones, the newest at the end
};

/// Milliseconds of all passes.
double total(const PassTimes& times);

/// Remembers a frame for the graph.
void add_frame(PanelState& state, PassTimes times);

/// Draws the panel into the current ImGui frame and takes what was changed.
void draw_panel(PanelState& state);

}  // namespace prt::gl
