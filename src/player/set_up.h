// Where to look from and what to light a scene with when nobody says.
#pragma once

#include "player/evaluator.h"
#include "scene/environment.h"

namespace prt {

/// The scene's light in the form that players use.
Light to_light(const SceneLight& light);

/// The package's first light, else a point light where most of the sampled surface sees it.
Light default_light(const Evaluator& evaluator);

/// For packages that take no lights: a clear sky above bright ground.
Environment default_environment();

/// The package's camera, else a view from inside the samples' bounding box along its longest
/// horizontal axis, from the place that most surface ahead sees; from outside if nothing sees any.
SceneCamera default_camera(const Evaluator& evaluator);

}  // namespace prt
