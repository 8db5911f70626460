#include "store/samples_io.h"

#include <algorithm>
#include <cmath>

namespace prt {

void put_samples(Artifact& artifact, const SampleSet& samples) {
  const std::uint64_t n = samples.size();
  artifact.put("position", samples.positions, "m", "sample positions, world space");
  artifact.put("normal", samples.normals, "1", "unit geometric normals on the sampled side");
  artifact.put("tangent", samples.tangents, "1", "unit tangents, smooth within a cluster");
  artifact.put<float>("radius", samples.radii, {n}, "m", "Poisson-disk radius at the sample");
  artifact.put<std::uint32_t>("triangle", samples.triangles, {n}, "1",
                              "triangle the sample lies on");
  artifact.put<std::uint32_t>("cluster_begin", samples.cluster_begin,
                              {samples.cluster_begin.size()}, "1",
                              "first sample of each cluster, then the number of samples");
  if (!samples.areas.empty()) {
    artifact.put<float>("area", samples.areas, {n}, "m^2", "area of the sample's cell");
  }
}

SampleSet get_samples(const Artifact& artifact) {
  SampleSet s;
  s.positions = artifact.points("position");
  s.normals = artifact.points("normal");
  s.tangents = artifact.points("tangent");
  s.radii = artifact.vector<float>("radius");
  s.triangles = artifact.vector<std::uint32_t>("triangle");
  s.cluster_begin = artifact.vector<std::uint32_t>("cluster_begin");
  if (artifact.has("area")) s.areas = artifact.vector<float>("area");
  const std::size_t n = s.size();
  const bool fits = s.normals.size() == n && s.tangents.size() == n && s.radii.size() == n &&
                    s.triangles.size() == n && (s.areas.empty() || s.areas.size() == n) &&
                    !s.cluster_begin.empty() && s.cluster_begin.front() == 0 &&
                    s.cluster_begin.back() == n &&
                    std::is_sorted(s.cluster_begin.begin(), s.cluster_begin.end());
  if (!fits) throw UnsoundData("the arrays of the samples do not fit together");
  const auto is_radius = [](float r) { return r > 0.0F && std::isfinite(r); };
  if (!std::ranges::all_of(s.radii, is_radius)) throw UnsoundData("a sample's radius is none");
  return s;
}

}  // namespace prt
