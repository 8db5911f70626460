#include "base/random.h"
#include "bases/function_basis.h"
#include "methods/common/inputs.h"
#include "methods/lb/tasks.h"
#include "transport/direct.h"
#include "transport/free_space.h"

namespace prt::lb {

namespace {

// Training lights keep half the distance from surfaces that test lights do (design: what "error"
// means).
constexpr float kClearance = 0.01F;
// 1/r² of an example light is clipped below this share of the samples' diagonal; measured on
// held-out lights, results/README.md.
constexpr float kNearest = 0.05F;

}  // namespace

Artifact run_lights(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto& p = task.parameters;
  const float clearance = kClearance * samples_diagonal(shared->samples);
  const auto lights =
      free_positions(reader.scene(), reader.ray_caster(), shared->samples, clearance,
                     stream_key(p["seed"].get<std::uint64_t>(), "example lights"),
                     p["first"].get<std::size_t>(), p["count"].get<std::size_t>());
  Artifact out;
  out.put("position", lights, "m", "example point lights");
  out.attributes["clearance"] = clearance;
  return out;
}

Artifact run_light_basis(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const SampleSet& samples = shared->samples;
  const auto cluster = task.parameters["cluster"].get<std::uint32_t>();
  std::vector<Vec3f> lights;
  for (std::size_t i = 1; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i)->points("position");
    lights.insert(lights.end(), part.begin(), part.end());
  }
  const MatrixF examples = direct_irradiance(
      reader.scene(), reader.ray_caster(), samples, samples.cluster_begin[cluster],
      samples.cluster_begin[cluster + 1], lights, kNearest * samples_diagonal(samples));
  check_stop(reader);
  const FunctionBasis basis = make_function_basis(examples, cluster_areas(samples, cluster),
                                                  task.parameters["rank"].get<int>());
  Artifact out;
  out.put("functions", basis.functions, "1/m", "light basis, orthonormal under cell areas");
  const VectorF areas = cluster_areas(samples, cluster);
  out.put("coefficients", basis.functions * areas.asDiagonal() * examples.transpose(), "W/m",
          "example lights in that basis");
  out.put<float>("coefficient_rms",
                 std::span<const float>(basis.coefficient_rms.data(),
                                        static_cast<std::size_t>(basis.coefficient_rms.size())),
                 {static_cast<std::uint64_t>(basis.coefficient_rms.size())}, "W/m",
                 "root mean square coefficient over the example lights");
  out.attributes = {{"cluster", cluster},
                    {"samples", samples.cluster_size(cluster)},
                    {"rank", basis.functions.rows()},
                    {"energy", basis.energy},
                    {"error", basis.error},
                    {"orthonormality_defect", basis.defect}};
  return out;
}

namespace {

/// Sizes by which functions are scaled; an unlit function keeps a tiny one, so that light from
/// where no example stood still counts.
VectorF function_scales(VectorF rms) {
  constexpr float kLeast = 1e-3F;
  const float largest = rms.size() > 0 ? rms.maxCoeff() : 0.0F;
  if (!(largest > 0.0F)) return VectorF::Ones(rms.size());
  return rms.cwiseMax(kLeast * largest);
}

void put_functions(Artifact& out, const ClusterFunctions& f) {
  out.put("values", f.values, "W/m^2", "functions of each sample's own cluster, zero padded");
  out.put<std::uint32_t>("begin", f.begin, {f.begin.size()}, "1", "first function of each cluster");
}

ClusterFunctions get_functions(const Artifact& a) {
  return {a.vector<std::uint32_t>("begin"), a.matrix("values")};
}

/// Collects inputs 1.. as functions, one input per cluster; `scale` gives each function's factor.
template <typename Scale>
ClusterFunctions collect(const TaskSpec& task, const TaskReader& reader, const SampleSet& samples,
                         Scale&& scale) {
  ClusterFunctions all;
  all.begin = {0};
  std::vector<MatrixF> parts;
  Eigen::Index most = 0;
  for (std::size_t i = 1; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i);
    parts.push_back(scale(*part).asDiagonal() * part->matrix("functions"));
    all.begin.push_back(all.begin.back() + static_cast<std::uint32_t>(parts.back().rows()));
    most = std::max(most, parts.back().rows());
  }
  all.values = MatrixF::Zero(static_cast<Eigen::Index>(samples.size()), most);
  for (std::size_t c = 0; c < parts.size(); ++c) {
    all.values.block(samples.cluster_begin[c], 0, parts[c].cols(), parts[c].rows()) =
        parts[c].transpose();
  }
  return all;
}

VectorF rms_of(const Artifact& part) {
  const auto rms = part.values<float>("coefficient_rms");
  return Eigen::Map<const VectorF>(rms.data(), static_cast<Eigen::Index>(rms.size()));
}

}  // namespace

Artifact run_light_functions(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const SampleSet& samples = shared->samples;
  Artifact out;
  put_functions(out, collect(task, reader, samples,
                             [](const Artifact& part) { return function_scales(rms_of(part)); }));
  const ClusterFunctions dual = collect(task, reader, samples, [](const Artifact& part) {
    return VectorF(function_scales(rms_of(part)).cwiseInverse());
  });
  MatrixF coefficients(dual.count(), reader.input(1)->at("coefficients").dims.at(1));
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const auto part = reader.input(c + 1);
    coefficients.middleRows(dual.begin[c], dual.of(c)) =
        function_scales(rms_of(*part)).cwiseInverse().asDiagonal() * part->matrix("coefficients");
  }
  out.put("coefficients", coefficients, "1", "example lights in the functions of all clusters");
  const Eigen::Map<const VectorF> areas(samples.areas.data(),
                                        static_cast<Eigen::Index>(samples.size()));
  out.put("projections", areas.asDiagonal() * dual.values, "m^2/W",
          "coefficient = sum over a cluster's samples of projection times irradiance");
  return out;
}

Artifact run_snapshot_functions(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  Artifact out;
  put_functions(
      out, collect(task, reader, shared->samples, [](const Artifact& part) {
        return VectorF(VectorF::Ones(static_cast<Eigen::Index>(part.at("functions").dims[0])));
      }));
  return out;
}

std::shared_ptr<const ClusterFunctions> shared_functions(const TaskReader& reader, std::size_t i) {
  return reader.memo().get<ClusterFunctions>("functions " + reader.input_content(i).hex(), [&] {
    return std::make_shared<ClusterFunctions>(get_functions(*reader.input(i)));
  });
}

std::shared_ptr<const MatrixF> shared_light_coefficients(const TaskReader& reader, std::size_t i) {
  return reader.memo().get<MatrixF>("coefficients " + reader.input_content(i).hex(), [&] {
    return std::make_shared<MatrixF>(reader.input(i)->matrix("coefficients"));
  });
}

LightFunctions get_light_functions(const Artifact& artifact) {
  return {get_functions(artifact), artifact.matrix("projections")};
}

}  // namespace prt::lb
