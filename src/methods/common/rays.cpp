#include "methods/common/rays.h"

#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/common/sampling.h"
#include "transport/hemisphere.h"

namespace prt {

std::size_t plan_rays(const PlanInputs& inputs, Plan& plan) {
  const auto samples = inputs.result(kSamplesTask);
  const auto begin = samples->values<std::uint32_t>("cluster_begin");
  const int directions = inputs.options().get<int>("rays.directions");
  for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
    TaskSpec spec;
    spec.id = numbered("rays", c);
    spec.kind = "rays";
    spec.version = 2;
    spec.inputs = {kSamplesTask};
    spec.scene_parts = kGeometry;
    spec.parameters = {{"cluster", c}, {"directions", directions}};
    spec.cost = 2e-7 * directions * (begin[c + 1] - begin[c]);
    spec.place = cluster_place(c);
    plan.tasks.push_back(spec);
  }
  return begin.size() - 1;
}

std::vector<std::string> rays_kinds() { return {"rays"}; }

Artifact run_rays(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto search = shared_search(reader, 0);
  const auto cluster = task.parameters["cluster"].get<std::uint32_t>();
  const HemisphereDirections directions(task.parameters["directions"].get<int>());
  const float bound = reader.scene().diagonal();
  const std::uint32_t begin = shared->samples.cluster_begin[cluster];
  const std::uint32_t end = shared->samples.cluster_begin[cluster + 1];
  const HemisphereRays rays = cast_hemispheres(reader.scene(), reader.ray_caster(), shared->samples,
                                               *search, directions, begin, end, bound);
  Artifact out;
  const std::vector<std::uint64_t> shape{end - begin,
                                         static_cast<std::uint64_t>(directions.count())};
  out.put<std::uint16_t>("distance", rays.distances, shape, "1",
                         "65534 sqrt(t / bound); 65535 where the ray escaped");
  out.put<std::uint32_t>("sender", rays.senders, shape, "1",
                         "sample hit; 4294967295 escaped, 4294967294 lost");
  out.attributes = {{"cluster", cluster},
                    {"samples", end - begin},
                    {"directions", directions.count()},
                    {"bound", bound},
                    {"escaped_share", rays.escaped_share},
                    {"lost_share", rays.lost_share},
                    {"back_hits", rays.back_hits}};
  return out;
}

}  // namespace prt
