#include "methods/common/inputs.h"

#include <fmt/format.h>

#include "base/error.h"
#include "store/samples_io.h"

namespace prt {

std::shared_ptr<const SharedSamples> shared_samples(const TaskReader& reader, std::size_t i) {
  return reader.memo().get<SharedSamples>("samples " + reader.input_content(i).hex(), [&] {
    return std::make_shared<SharedSamples>(reader.scene(), get_samples(*reader.input(i)));
  });
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

void check_stop(const TaskReader& reader) {
  if (reader.stop_requested()) throw Interrupted("asked to stop");
}

}  // namespace prt
