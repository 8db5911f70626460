// prt_bake --plan: what would be made, what is there already, what is left out and why.
#pragma once

#include <string>

#include "apps/bake/planner.h"
#include "store/manifest.h"

namespace prt {

/// Plans as far as the artifacts on disk allow. Looks only; makes nothing.
std::string preview_plan(Planner& planner, const ArtifactStore& store, const SceneHashes& scene,
                         const ManifestContents& manifest);

}  // namespace prt
