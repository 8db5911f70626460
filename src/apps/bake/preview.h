// prt_bake --plan: what would be made, what is there already, what is left out and why.
#pragma once

#include <string>
#include <vector>

#include "apps/bake/planner.h"
#include "apps/bake/prediction.h"
#include "store/manifest.h"

namespace prt {

/// Plans as far as the artifacts on disk allow. Looks only; makes nothing.
std::string preview_plan(Planner& planner, const ArtifactStore& store, const SceneHashes& scene,
                         const ManifestContents& manifest);

/// What the whole bake would take, as a table, with the survey of the scene and what is left out.
/// `threads`: that each rank would run, `ranks`: of them.
std::string prediction_text(const BakePrediction& prediction, int threads, int ranks);

/// Wall seconds of each level of effort, the coarsest first, as far as a small bake can tell.
std::string levels_text(const std::vector<double>& seconds);

}  // namespace prt
