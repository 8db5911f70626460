#include "methods/common/inputs.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/hash.h"
#include "store/samples_io.h"

namespace prt {

namespace {

/// Names all that a neighbour search depends on, but for the scene.
std::string search_name(const Artifact& samples) {
  Hasher hasher;
  for (const char* array : {"position", "normal", "radius", "triangle"}) {
    hasher.add(samples.at(array).bytes);
  }
  return "search " + hasher.digest().hex();
}

/// A search and the samples it points into.
struct OwningSearch {
  OwningSearch(const Scene& scene, std::shared_ptr<const SharedSamples> shared)
      : owner(std::move(shared)), search(scene, owner->samples) {}
  std::shared_ptr<const SharedSamples> owner;
  SenderSearch search;
};

}  // namespace

std::shared_ptr<const SharedSamples> shared_samples(const TaskReader& reader, std::size_t i) {
  return reader.memo().get<SharedSamples>("samples " + reader.input_content(i).hex(), [&] {
    return std::make_shared<SharedSamples>(get_samples(*reader.input(i)));
  });
}

std::shared_ptr<const SenderSearch> shared_search(const TaskReader& reader, std::size_t i) {
  const auto name = reader.memo().get<std::string>(
      "search of " + reader.input_content(i).hex(),
      [&] { return std::make_shared<std::string>(search_name(*reader.input(i))); });
  const auto owning = reader.memo().get<OwningSearch>(*name, [&] {
    return std::make_shared<OwningSearch>(reader.scene(), shared_samples(reader, i));
  });
  return {owning, &owning->search};
}

VectorF cluster_areas(const SampleSet& samples, std::uint32_t cluster) {
  return Eigen::Map<const VectorF>(samples.areas.data() + samples.cluster_begin[cluster],
                                   samples.cluster_size(cluster));
}

void append_cell_points(const Artifact& part, CellPoints& points) {
  const auto samples = part.values<std::uint32_t>("sample");
  const auto triangles = part.values<std::uint32_t>("triangle");
  const auto barycentric = part.values<float>("barycentric");
  points.samples.insert(points.samples.end(), samples.begin(), samples.end());
  points.triangles.insert(points.triangles.end(), triangles.begin(), triangles.end());
  points.barycentric.insert(points.barycentric.end(), barycentric.begin(), barycentric.end());
}

std::string numbered(const std::string& stage, std::size_t i) {
  return fmt::format("{}/{:04}", stage, i);
}

std::string cluster_place(std::size_t c) { return numbered("cluster", c); }

void check_stop(const TaskReader& reader) {
  if (reader.stop_requested()) throw Interrupted("asked to stop");
}

}  // namespace prt
