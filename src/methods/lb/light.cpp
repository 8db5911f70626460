#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "bases/effect_basis.h"
#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/lb/tasks.h"
#include "transport/direct.h"
#include "transport/free_space.h"
#include "transport/gather.h"
#include "transport/hemisphere.h"

namespace prt::lb {

namespace {

// Training lights keep half the distance from surfaces that test lights do (design: what "error"
// means).
constexpr float kClearance = 0.01F;
// 1/r² of an example light is clipped below this share of the samples' diagonal, or a few lights
// close to a surface would own the basis. 0.04 did better than 0.02 on 16
// lights of the gallery kept out of the training, at 12,000 samples; not tuned further.
constexpr float kNearest = 0.04F;
// Patches in which the effect of direct light is told apart, over the whole scene ...
constexpr std::size_t kPatches = 1536;
// ... and rows into which their channels are summed up with random signs (count sketch: Clarkson &
// Woodruff 2013, "Low rank approximation and regression in input sparsity time"). On the gallery
// the basis is as good as from all 4,608 rows, for a ninth of the work.
constexpr std::size_t kEffectRows = 512;
constexpr std::uint64_t kSketchStream = 0x9a7c4;
// A cluster may use up to this many times the mean number of light functions.
constexpr int kMostPerRank = 4;

}  // namespace

Artifact run_lights(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto& p = task.parameters;
  const float clearance = light_clearance(shared->samples, kClearance);
  const auto lights =
      free_positions(reader.scene(), reader.ray_caster(), shared->samples, clearance,
                     stream_key(p["seed"].get<std::uint64_t>(), "example lights"),
                     p["first"].get<std::size_t>(), p["count"].get<std::size_t>());
  Artifact out;
  out.put("position", lights, "m", "example point lights");
  out.attributes["clearance"] = clearance;
  return out;
}

namespace {

/// Patches of about equal size within clusters: where the effect of direct light is felt.
struct Patches {
  std::vector<std::uint32_t> of_sample;
  std::vector<double> areas;
};

Patches make_patches(const SampleSet& samples) {
  Patches patches;
  const std::size_t size = (samples.size() + kPatches - 1) / kPatches;
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const std::size_t n = samples.cluster_size(c);
    const std::size_t count = std::max<std::size_t>(1, n / std::max<std::size_t>(1, size));
    const auto first = static_cast<std::uint32_t>(patches.areas.size());
    patches.areas.resize(first + count, 0.0);
    // Samples of a cluster follow a space-filling curve: runs of them are compact.
    for (std::size_t i = 0; i < n; ++i) {
      const auto patch = first + static_cast<std::uint32_t>(i * count / n);
      patches.of_sample.push_back(patch);
      patches.areas[patch] += samples.areas[samples.cluster_begin[c] + i];
    }
  }
  return patches;
}

/// What irradiance on a cluster's samples causes: once-reflected flux into every patch over the
/// root of its area, per colour channel, sketched: kEffectRows × n_c. By reciprocity it is read off
/// the cluster's own rays: A_j·G(j, s) = A_s·G(s, j). Entries G(j, s) above near_share are
/// left out: they get transfer of their own (1: none does).
MatrixF patch_effect(const Artifact& rays, const MatrixF& albedo, const SampleSet& samples,
                     std::uint32_t begin, const Patches& patches, float near_share) {
  const HemisphereDirections directions(rays.attribute<int>("directions"));
  const GatherEntries entries =
      gather_entries(rays.values<std::uint32_t>("sender"), directions.weights(), samples.size());
  const bool grey = (albedo.rowwise().maxCoeff() - albedo.rowwise().minCoeff()).maxCoeff() == 0.0F;
  const Eigen::Index channels = grey ? 1 : albedo.cols();
  struct Target {
    std::uint32_t row;
    float factor;
  };
  std::vector<Target> targets;  // per patch and channel
  for (std::size_t p = 0; p < patches.areas.size(); ++p) {
    const auto scale = static_cast<float>(1.0 / std::sqrt(patches.areas[p]));
    for (Eigen::Index c = 0; c < channels; ++c) {
      Random random(kSketchStream, targets.size());
      const std::uint32_t row = random.below(kEffectRows);
      targets.push_back({row, random.uniform() < 0.5F ? -scale : scale});
    }
  }
  MatrixF effect = MatrixF::Zero(albedo.rows(), kEffectRows);
  for (Eigen::Index s = 0; s < albedo.rows(); ++s) {
    const float area = samples.areas[begin + s];
    float* row = effect.row(s).data();
    for (std::uint32_t k = entries.begin[s]; k < entries.begin[s + 1]; ++k) {
      const std::uint32_t j = entries.senders[k];
      const bool near =
          near_share < 1.0F && entries.shares[k] * area > near_share * samples.areas[j];
      if (near) continue;
      const Target* target = &targets[patches.of_sample[j] * channels];
      for (Eigen::Index c = 0; c < channels; ++c) {
        row[target[c].row] += target[c].factor * albedo(s, c) * area * entries.shares[k];
      }
    }
  }
  return effect.transpose();
}

/// One function for a cluster without effect: the constant.
void add_constant(EffectBasis& basis, const VectorF& areas) {
  basis.functions = MatrixF::Ones(1, areas.size());
  basis.projections = areas.transpose() / areas.sum();
  basis.strengths = VectorF::Zero(1);
}

void put_rows(Artifact& out, const EffectBasis& basis) {
  out.put("functions", basis.functions, "1", "light functions: direct light that matters");
  out.put("projections", basis.projections, "1",
          "coefficient = sum of projection times irradiance");
  out.put<float>("strengths",
                 std::span<const float>(basis.strengths.data(),
                                        static_cast<std::size_t>(basis.strengths.size())),
                 {static_cast<std::uint64_t>(basis.strengths.size())}, "W/m",
                 "effect that hangs on each function, over all example lights");
}

}  // namespace

Artifact run_light_basis(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const SampleSet& samples = shared->samples;
  const auto cluster = task.parameters["cluster"].get<std::uint32_t>();
  const std::uint32_t begin = samples.cluster_begin[cluster];
  const std::uint32_t size = samples.cluster_size(cluster);
  std::vector<Vec3f> lights;
  for (std::size_t i = 3; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i)->points("position");
    lights.insert(lights.end(), part.begin(), part.end());
  }
  const MatrixF examples =
      direct_irradiance(reader.scene(), reader.ray_caster(), samples, begin, begin + size, lights,
                        kNearest * samples_diagonal(samples));
  check_stop(reader);
  const VectorF areas = cluster_areas(samples, cluster);
  const MatrixF albedo = reader.input(1)->matrix("albedo").middleRows(begin, size);
  const MatrixF effect =
      patch_effect(*reader.input(2), albedo, samples, begin, make_patches(samples),
                   task.parameters["near_share"].get<float>());
  check_stop(reader);
  EffectBasis basis =
      make_effect_basis(effect, examples, kMostPerRank * task.parameters["rank"].get<int>());
  if (basis.functions.rows() == 0) add_constant(basis, areas);
  Artifact out;
  put_rows(out, basis);
  out.put("coefficients", basis.projections * examples.transpose(), "W/m^2",
          "example lights in the light functions");
  out.attributes = {{"cluster", cluster},
                    {"samples", size},
                    {"rank", basis.functions.rows()},
                    {"energy", basis.energy},
                    {"error", std::sqrt(std::max(0.0, 1.0 - basis.energy))},
                    {"biorthogonality_defect", basis.defect}};
  return out;
}

namespace {

/// How many functions each cluster keeps: those with the greatest effect of all, `mean` per cluster
/// taken together, one at least, and none that are needless: those together may hold `tolerance` of
/// the effect.
struct Shares {
  std::vector<Eigen::Index> kept;  ///< of each cluster
  std::size_t needless = 0;        ///< for which there would have been room
  double needless_effect = 0.0;    ///< of all that are too weak, relative
};

Shares share_out(const std::vector<VectorF>& strengths, std::size_t mean, double tolerance) {
  struct Offer {
    float strength;
    std::uint32_t cluster;
  };
  std::vector<Offer> offers;
  Shares shares;
  shares.kept.assign(strengths.size(), 1);
  double all = 0.0;
  for (std::uint32_t c = 0; c < strengths.size(); ++c) {
    all += strengths[c].cast<double>().squaredNorm();
    for (Eigen::Index k = 1; k < strengths[c].size(); ++k) offers.push_back({strengths[c][k], c});
  }
  std::stable_sort(offers.begin(), offers.end(),
                   [](const Offer& a, const Offer& b) { return a.strength > b.strength; });
  const std::size_t room = std::min((mean - 1) * strengths.size(), offers.size());
  double weak = 0.0;  // from the weakest on, so that no small one is lost in the sum
  while (!offers.empty()) {
    const double with_next = weak + std::pow(static_cast<double>(offers.back().strength), 2);
    if (with_next > tolerance * tolerance * all) break;
    weak = with_next;
    offers.pop_back();
  }
  shares.needless_effect = all > 0.0 ? std::sqrt(weak / all) : 0.0;
  shares.needless = room - std::min(room, offers.size());
  offers.resize(std::min(room, offers.size()));
  for (const Offer& offer : offers) ++shares.kept[offer.cluster];
  return shares;
}

/// Size of a function's coefficient over the example lights; where no example stood it keeps a tiny
/// one, so that light from there still counts.
VectorF typical_sizes(const MatrixF& coefficients) {
  constexpr float kLeast = 1e-3F;
  const float lights = static_cast<float>(std::max<Eigen::Index>(1, coefficients.cols()));
  const VectorF rms = coefficients.rowwise().norm() / std::sqrt(lights);
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

/// Functions of all clusters side by side; parts[c] is k_c × n_c.
ClusterFunctions collect(const std::vector<MatrixF>& parts, const SampleSet& samples) {
  ClusterFunctions all;
  all.begin = {0};
  Eigen::Index most = 0;
  for (const MatrixF& part : parts) {
    all.begin.push_back(all.begin.back() + static_cast<std::uint32_t>(part.rows()));
    most = std::max(most, part.rows());
  }
  // Whole registers, so that no task has to copy all of it to make it so.
  most = (most + kGatherLane - 1) / kGatherLane * kGatherLane;
  all.values = MatrixF::Zero(static_cast<Eigen::Index>(samples.size()), most);
  for (std::size_t c = 0; c < parts.size(); ++c) {
    all.values.block(samples.cluster_begin[c], 0, parts[c].cols(), parts[c].rows()) =
        parts[c].transpose();
  }
  return all;
}

}  // namespace

Artifact run_light_functions(const TaskSpec& task, const TaskReader& reader) {
  const SampleSet& samples = shared_samples(reader, 0)->samples;
  std::vector<VectorF> strengths;
  for (std::size_t i = 1; i < task.inputs.size(); ++i) {
    const auto values = reader.input(i)->values<float>("strengths");
    strengths.emplace_back(
        Eigen::Map<const VectorF>(values.data(), static_cast<Eigen::Index>(values.size())));
  }
  const Shares shares = share_out(strengths, task.parameters["rank"].get<std::size_t>(),
                                  task.parameters["tolerance"].get<double>());
  const std::vector<Eigen::Index>& kept = shares.kept;
  std::vector<MatrixF> functions;
  std::vector<MatrixF> projections;
  std::vector<MatrixF> coefficients;
  for (std::size_t c = 0; c < kept.size(); ++c) {
    const auto part = reader.input(c + 1);
    const MatrixF seen = part->matrix("coefficients").topRows(kept[c]);
    const VectorF size = typical_sizes(seen);
    functions.emplace_back(size.asDiagonal() * part->matrix("functions").topRows(kept[c]));
    projections.emplace_back(size.cwiseInverse().asDiagonal() *
                             part->matrix("projections").topRows(kept[c]));
    coefficients.emplace_back(size.cwiseInverse().asDiagonal() * seen);
  }
  Artifact out;
  const ClusterFunctions all = collect(functions, samples);
  put_functions(out, all);
  out.put("projections", collect(projections, samples).values, "m^2/W",
          "coefficient = sum over a cluster's samples of projection times irradiance");
  MatrixF lights(all.count(), coefficients[0].cols());
  for (std::size_t c = 0; c < kept.size(); ++c) {
    lights.middleRows(all.begin[c], kept[c]) = coefficients[c];
  }
  out.put("coefficients", lights, "1", "example lights in the functions of all clusters");
  out.attributes = {{"functions", all.count()},
                    {"needless", shares.needless},
                    {"needless_effect", shares.needless_effect},
                    {"largest_rank", *std::max_element(kept.begin(), kept.end())}};
  return out;
}

Artifact run_snapshot_functions(const TaskSpec& task, const TaskReader& reader) {
  std::vector<MatrixF> functions;
  for (std::size_t i = 1; i < task.inputs.size(); ++i) {
    functions.push_back(reader.input(i)->matrix("functions"));
  }
  Artifact out;
  put_functions(out, collect(functions, shared_samples(reader, 0)->samples));
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
