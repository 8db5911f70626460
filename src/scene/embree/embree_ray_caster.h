// RayCaster over Embree 3.13 or 4: the only place that includes Embree.
#pragma once

#include <memory>
#include <string>

#include "scene/ray_caster.h"

namespace prt {

/// Builds the acceleration structure on one thread, robust, medium quality. `isa` pins Embree's
/// instruction set ("avx2", "avx512", ...; empty: Embree's choice). The scene must outlive the
/// caster. Triangles with alpha masks lie in a geometry of their own with a filter, so opaque ones
/// pay nothing.
std::unique_ptr<RayCaster> make_embree_ray_caster(const Scene& scene, const std::string& isa = "");

/// Highest instruction set that both this CPU and the linked Embree support: "sse2", "sse4.2",
/// "avx", "avx2" or "avx512".
std::string best_embree_isa();

}  // namespace prt
