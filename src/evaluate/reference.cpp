#include "evaluate/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "transport/cells.h"
#include "transport/free_space.h"

namespace prt {
namespace {

/// Points per piece of parallel work: a whole number of the path tracer's waves.
constexpr std::size_t kGrain = 32;
/// Points drawn per point wanted, at first: about half of a room's two-sided surface is reachable.
constexpr std::uint64_t kFirstDraw = 2;
/// Draws at most, per point wanted: less reachable surface than that is none.
constexpr std::uint64_t kMostDraws = 4096;

std::uint64_t light_stream(const ReferenceSettings& settings, const std::string& name,
                           std::size_t number) {
  return stream_key(settings.seed, fmt::format("test {} {}", name, number));
}

/// `wanted` of `count` things at even distances, from a random start: ascending numbers.
std::vector<std::size_t> spread(std::size_t count, std::size_t wanted, Random& random) {
  const double step = static_cast<double>(count) / static_cast<double>(wanted);
  const double start = random.uniform();
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < wanted; ++k) {
    const double place = (static_cast<double>(k) + start) * step;
    chosen.push_back(std::min(count - 1, static_cast<std::size_t>(place)));
  }
  return chosen;
}

/// Of a point light of 1 W/sr, at every sample.
std::vector<float> trace_direct(const ReferenceInputs& inputs, const Vec3f& light) {
  std::vector<float> direct(inputs.samples.size(), 0.0F);
  for (std::size_t s = 0; s < direct.size(); ++s) {
    const Vec3f& position = inputs.samples.positions[s];
    const Vec3f& normal = inputs.samples.normals[s];
    const Vec3f to_light = light - position;
    const float squared = to_light.squaredNorm();
    const float cosine = normal.dot(to_light) / std::sqrt(squared);
    if (!(cosine > 0.0F)) continue;
    if (inputs.caster.visible(offset_origin(inputs.scene, position, normal), light)) {
      direct[s] = cosine / squared;
    }
  }
  return direct;
}

}  // namespace

Light draw_test_light(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                      std::size_t number) {
  Light light;
  light.position = free_positions(inputs.scene, inputs.caster, inputs.samples, settings.clearance,
                                  stream_key(settings.seed, "test lights"), number, 1)[0];
  return light;
}

void choose_sample_points(const SampleSet& samples, const ReferenceSettings& settings,
                          std::size_t number, TestPoints& out) {
  std::vector<double> cumulative;
  double total = 0.0;
  for (const float area : samples.areas) cumulative.push_back(total += area);
  out.at_samples = {};
  out.sample_index.clear();
  const auto add = [&](std::uint32_t s, float weight) {
    out.sample_index.push_back(s);
    out.at_samples.points.push_back({samples.positions[s], samples.normals[s]});
    out.at_samples.weights.push_back(weight);
  };
  if (settings.points >= samples.size()) {
    for (std::uint32_t s = 0; s < samples.size(); ++s) {
      add(s, static_cast<float>(samples.areas[s] / total));
    }
    return;
  }
  const auto wanted = static_cast<double>(settings.points);
  const std::uint64_t stream = light_stream(settings, "samples", number);
  for (std::size_t k = 0; k < settings.points; ++k) {
    const double place = (static_cast<double>(k) + Random(stream, k).uniform()) / wanted * total;
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, place);
    add(static_cast<std::uint32_t>(found - cumulative.begin()), static_cast<float>(1.0 / wanted));
  }
}

void choose_surface_points(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                           std::size_t number, TestPoints& out) {
  const std::vector<double> cumulative = cumulative_areas(inputs.scene);
  const std::uint64_t stream = light_stream(settings, "surface", number);
  CellPoints drawn;
  for (std::uint64_t factor = kFirstDraw; drawn.samples.size() < settings.points; factor *= 2) {
    if (factor > kMostDraws) {
      throw UserError("no surface near the samples: do the package and its scene belong together?");
    }
    const std::uint64_t total = factor * settings.points;
    drawn = draw_cell_points(inputs.scene, inputs.caster, inputs.samples, inputs.search, cumulative,
                             total, 0, total, stream + factor);
  }
  Random random(stream, 0);
  out.on_surface = {};
  const float weight = 1.0F / static_cast<float>(settings.points);
  for (const std::size_t k : spread(drawn.samples.size(), settings.points, random)) {
    const std::uint32_t triangle = drawn.triangles[k];
    // A point stands for one side: the one its sample is on.
    Vec3f normal = triangle_normal(inputs.scene, triangle);
    if (normal.dot(inputs.samples.normals[drawn.samples[k]]) < 0.0F) normal = -normal;
    out.on_surface.points.push_back(
        {triangle_point(inputs.scene, triangle, drawn.barycentric[2 * k],
                        drawn.barycentric[2 * k + 1]),
         normal});
    out.on_surface.weights.push_back(weight);
  }
}

std::vector<IrradianceEstimate> trace_in_parallel(const Scene& scene, const RayCaster& caster,
                                                  std::span<const Light> lights,
                                                  std::span<const ReceiverPoint> points,
                                                  const PathTracerSettings& settings,
                                                  std::uint64_t stream, unsigned threads,
                                                  const std::function<void()>& progress) {
  std::vector<IrradianceEstimate> estimates(points.size());
  parallel_for(points.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    const auto part = trace_irradiance(scene, caster, lights, points.subspan(begin, end - begin),
                                       settings, stream, begin);
    std::copy(part.begin(), part.end(), estimates.begin() + static_cast<std::ptrdiff_t>(begin));
    progress();
  });
  return estimates;
}

LightReference trace_reference(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                               std::size_t number, unsigned threads,
                               const std::function<void()>& progress) {
  LightReference reference;
  reference.light = draw_test_light(inputs, settings, number);
  choose_sample_points(inputs.samples, settings, number, reference);
  choose_surface_points(inputs, settings, number, reference);
  reference.direct = trace_direct(inputs, reference.light.position);
  const auto trace = [&](TestSet& set, const std::string& name) {
    set.reference = trace_in_parallel(inputs.scene, inputs.caster, {&reference.light, 1},
                                      set.points, {.paths = settings.paths},
                                      light_stream(settings, name, number), threads, progress);
  };
  trace(reference.at_samples, "paths at samples");
  trace(reference.on_surface, "paths on the surface");
  return reference;
}

TestPoints trace_sky_reference(const ReferenceInputs& inputs, const ReferenceSettings& settings,
                               std::size_t number, const Environment& environment, unsigned threads,
                               const std::function<void()>& progress) {
  TestPoints reference;
  choose_sample_points(inputs.samples, settings, number, reference);
  choose_surface_points(inputs, settings, number, reference);
  const auto trace = [&](TestSet& set, const std::string& name) {
    set.reference = trace_in_parallel(inputs.scene, inputs.caster, {}, set.points,
                                      {.paths = settings.paths, .environment = &environment},
                                      light_stream(settings, name, number), threads, progress);
  };
  trace(reference.at_samples, "sky at samples");
  trace(reference.on_surface, "sky on the surface");
  return reference;
}

}  // namespace prt
