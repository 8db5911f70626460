// What a package is judged by: test lights, test points, and their path-traced irradiance.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "domains/samples.h"
#include "scene/light.h"
#include "scene/ray_caster.h"
#include "transport/path_tracer.h"
#include "transport/sender_search.h"

namespace prt {

struct ReferenceSettings {
  std::uint64_t seed = 1;
  std::size_t points = 1000;  ///< at the samples, and as many on the surface
  int paths = 64;             ///< per point and light; half of them in each of the two references
  float clearance = 0.0F;     ///< of the lights from every surface, m
};

/// Default clearance relative to samples_diagonal() (design: what "error" means); training lights
/// keep half of it.
inline constexpr float kTestClearance = 0.02F;

/// Points with the share of the area each stands for (sum 1), and what is true there.
struct TestSet {
  std::vector<ReceiverPoint> points;
  std::vector<float> weights;
  std::vector<IrradianceEstimate> reference;  ///< as many as points once traced, W/m²
};

/// Where a package is judged.
struct TestPoints {
  TestSet at_samples;  ///< sample_index.size() points
  std::vector<std::uint32_t> sample_index;
  TestSet on_surface;
};

/// One test light with everything it is compared by; at_samples is for indirect light.
struct LightReference : TestPoints {
  Light light;  ///< white point light, 1 W/sr
  /// Direct irradiance at every sample, W/m², exact: 0 where it faces away or a ray to the light is
  /// blocked.
  std::vector<float> direct;
};

/// Where references come from; the objects must outlive the calls.
struct ReferenceInputs {
  const Scene& scene;
  const RayCaster& caster;
  const SampleSet& samples;
  const SenderSearch& search;
};

/// Test light `number` of the seed, in the free space, from random numbers that no bake uses.
/// Throws UserError if there is no room for it.
Light draw_test_light(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                      std::size_t number);

/// Chooses `settings.points` samples for light `number`, each with a chance in proportion to its
/// cell area and one from every equal share of it, so all weights are equal. All samples with their
/// areas as weights when that many are asked for.
void choose_sample_points(const SampleSet& samples, const ReferenceSettings& settings,
                          std::size_t number, TestPoints& out);

/// Area-uniform random points of the reachable surface for light `number`: the surface that cells
/// are measured on, with other random numbers. Throws UserError if it has none.
void choose_surface_points(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                           std::size_t number, TestPoints& out);

/// Traces light `number`: light, points, visibility and irradiance, on `threads` threads (a baking
/// task asks for 1). `progress` is called after every few points and may throw; from several
/// threads if there are.
LightReference trace_reference(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                               std::size_t number, unsigned threads,
                               const std::function<void()>& progress);

/// The same for an environment, direct and indirect light at the same points; `number` chooses
/// them.
TestPoints trace_sky_reference(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                               std::size_t number, const Environment& environment, unsigned threads,
                               const std::function<void()>& progress);

/// Irradiance of lights at points, on `threads` threads; what trace_reference() does for its sets.
/// The results do not depend on the threads.
std::vector<IrradianceEstimate> trace_in_parallel(const Scene& scene, const RayCaster& caster,
                                                  std::span<const Light> lights,
                                                  std::span<const ReceiverPoint> points,
                                                  const PathTracerSettings& settings,
                                                  std::uint64_t stream, unsigned threads,
                                                  const std::function<void()>& progress);

}  // namespace prt
