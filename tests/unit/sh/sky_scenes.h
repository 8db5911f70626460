// Small scenes under the sky, and bakes of them.
#pragma once

#include "bases/spherical_harmonics.h"
#include "methods/combined.h"
#include "methods/common/inputs.h"
#include "methods/common/sampling.h"
#include "methods/sh/sh.h"
#include "scene/environment.h"
#include "statistical/test_scenes.h"
#include "store/samples_io.h"
#include "support/in_process_bake.h"

namespace prt::test {

/// A box of 2 m without a lid, seen from inside.
inline Scene open_box(const Vec3f& albedo) {
  Scene scene;
  add_box(scene, Vec3f::Zero(), Vec3f::Constant(2.0F), add_material(scene, albedo));
  // The lid is the side at y = 2 that looks down.
  std::erase_if(scene.triangles, [&](const Triangle& t) {
    return std::ranges::all_of(t.vertex,
                               [&](std::uint32_t v) { return scene.positions[v].y() > 1.9F; });
  });
  finish(scene);
  return scene;
}

inline Scene ball(const Vec3f& albedo) {
  Scene scene;
  add_icosphere(scene, 2, add_material(scene, albedo));
  finish(scene);
  return scene;
}

inline OptionValues sky_options(const Method& method, int samples, const Vec3d& start) {
  OptionValues options = default_options(method);
  options.set("samples.count", samples);
  options.set("samples.cluster_size", 200);
  options.set("samples.start", {start.x(), start.y(), start.z()});
  return options;
}

/// Radiance 1 + 0.5 y + 0.3 x in direction (x, y, z), times a colour: bands 0 and 1 alone.
inline Environment two_bands(const Vec3f& colour) {
  constexpr int kRows = 128;
  std::vector<Vec3f> radiance;
  const Environment grid(2 * kRows, kRows, std::vector<Vec3f>(2UL * kRows * kRows, Vec3f::Zero()));
  grid.visit(kRows, [&](const Vec3d& d, double, const Vec3f&) {
    radiance.emplace_back(static_cast<float>(1.0 + 0.5 * d.y() + 0.3 * d.x()) * colour);
  });
  return {2 * kRows, kRows, std::move(radiance)};
}

}  // namespace prt::test
