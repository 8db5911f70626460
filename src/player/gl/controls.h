// What mouse and keys do to camera and light. No window in here. Internal to player/gl.
#pragma once

#include "scene/light.h"
#include "scene/scene.h"

namespace prt::gl {

/// Movement in pixels, x to the right, y down.
struct Drag {
  float x = 0.0F;
  float y = 0.0F;
};

/// Turns the eye round the target; never over the poles.
SceneCamera orbited(const SceneCamera& camera, const Drag& drag);
/// Turns the view where the eye stands.
SceneCamera turned(const SceneCamera& camera, const Drag& drag);
/// Moves eye and target: x right, y up, z ahead along the view, m.
SceneCamera walked(const SceneCamera& camera, const Vec3f& step);
/// Moves the eye to the target and back: positive steps nearer.
SceneCamera zoomed(const SceneCamera& camera, float steps);
/// The eye on a circle round the target, about the axis that is up.
SceneCamera turntable(const SceneCamera& camera, float turns);

/// Moves the light with the mouse: parallel to the image so that it stays below the pointer, or,
/// in `depth`, towards the eye and away. The sun turns instead.
Light dragged(const Light& light, const Drag& drag, bool depth, const SceneCamera& camera,
              int image_height);

/// A light of another kind in the same place that lights the scene about as much. `size` is the
/// scene's diagonal, m.
Light as_kind(const Light& light, Light::Kind kind, float size);

}  // namespace prt::gl
