#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/random.h"
#include "bases/effect_basis.h"
#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/lb/scene_part.h"
#include "methods/lb/tasks.h"
#include "transport/direct.h"
#include "transport/free_space.h"
#include "transport/gather.h"
#include "transport/hemisphere.h"

namespace prt::lb {

namespace {

// Training lights keep half the distance from surfaces that test lights do (design: what "error"
// means); in a scene of several regions it is a share of the region's diagonal.
constexpr float kClearance = 0.01F;
// 1/r² of an example light is clipped below this share of the region's diagonal, or a few lights
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
constexpr std::uint64_t kSumStream = 0x50b7a;
// A cluster may use up to this many times the mean number of light functions.
constexpr int kMostPerRank = 4;

}  // namespace

namespace {

/// Free positions for lights in a part of a scene, nearer to surfaces where there is little room,
/// and none where there is no room at all: a region may be a crack between two walls.
std::vector<Vec3f> positions_in_region(const TaskReader& reader, const SampleSet& samples,
                                       float& clearance, std::uint64_t stream, std::size_t first,
                                       std::size_t count) {
  constexpr int kTries = 4;
  for (int i = 0; i < kTries; ++i, clearance /= 4.0F) {
    try {
      return free_positions(reader.scene(), reader.ray_caster(), samples, clearance, stream, first,
                            count);
    } catch (const UserError&) {
      check_stop(reader);
    }
  }
  return {};
}

}  // namespace

Artifact run_lights(const TaskSpec& task, const TaskReader& reader) {
  const auto region = shared_region(task, reader);
  const auto& p = task.parameters;
  float clearance = light_clearance(region->samples(), kClearance);
  std::uint64_t stream = stream_key(p["seed"].get<std::uint64_t>(), "example lights");
  const auto first = p["first"].get<std::size_t>();
  const auto count = p["count"].get<std::size_t>();
  std::vector<Vec3f> lights;
  if (region->is_whole()) {
    lights = free_positions(reader.scene(), reader.ray_caster(), region->samples(), clearance,
                            stream, first, count);
  } else {
    stream = stream_key(stream, "region " + std::to_string(p["region"].get<std::size_t>()));
    lights = positions_in_region(reader, region->samples(), clearance, stream, first, count);
  }
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
MatrixF patch_effect(const Artifact& rays, const ScenePart& part, const MatrixF& albedo,
                     std::uint32_t begin, float near_share) {
  const SampleSet& samples = part.samples();
  const Patches patches = make_patches(samples);
  const HemisphereDirections directions(rays.attribute<int>("directions"));
  const GatherEntries entries =
      gather_entries(part.local_senders(rays.values<std::uint32_t>("sender")), directions.weights(),
                     samples.size());
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

namespace {

/// Example lights of a cluster.
struct Examples {
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> column;  ///< in which each is summed up ...
  std::vector<float> sign;            ///< ... and with which sign
  Eigen::Index columns = 0;           ///< 0: each is its own column
};

/// Inputs 3, 4, ... In a window the regions that light may come from ("light_regions") have so many
/// of them each ("lights_inputs"). Coefficients are wanted of all lights, yet a window knows those
/// of its own clusters alone: so the first lights of all regions are one example, the second ones
/// another, and every cluster of the scene knows its part of each. With random signs (a count
/// sketch) their products keep those of single lights in the mean.
Examples read_examples(const TaskSpec& task, const TaskReader& reader) {
  const auto& p = task.parameters;
  std::vector<std::uint64_t> regions = {0};
  std::size_t inputs = own_inputs(task) - 3;
  if (p.contains("light_regions")) {
    regions = p["light_regions"].get<std::vector<std::uint64_t>>();
    inputs = p["lights_inputs"].get<std::size_t>();
  }
  Examples examples;
  std::size_t next = 3;
  for (const std::uint64_t region : regions) {
    std::uint32_t light = 0;
    for (std::size_t i = 0; i < inputs; ++i) {
      for (const Vec3f& position : reader.input(next++)->points("position")) {
        examples.positions.push_back(position);
        examples.column.push_back(light);
        // The same sign whichever cluster looks at the light.
        const bool negative =
            Random(stream_key(kSumStream, std::to_string(region)), light).bits() % 2 == 1;
        examples.sign.push_back(negative ? -1.0F : 1.0F);
        ++light;
      }
    }
  }
  if (p.contains("light_regions")) examples.columns = p["lights"].get<Eigen::Index>();
  return examples;
}

/// Coefficients of every example, k × lights, summed up by column.
MatrixF sum_up(const MatrixF& coefficients, const Examples& examples) {
  if (examples.columns == 0) return coefficients;
  MatrixF sums = MatrixF::Zero(coefficients.rows(), examples.columns);
  for (Eigen::Index l = 0; l < coefficients.cols(); ++l) {
    sums.col(examples.column[l]) += examples.sign[l] * coefficients.col(l);
  }
  return sums;
}

}  // namespace

Artifact run_light_basis(const TaskSpec& task, const TaskReader& reader) {
  const auto part = shared_window(task, reader);
  const SampleSet& samples = part->samples();
  const auto number = task.parameters["cluster"].get<std::uint32_t>();
  const std::uint32_t cluster = part->local(number);
  const std::uint32_t begin = samples.cluster_begin[cluster];
  const std::uint32_t size = samples.cluster_size(cluster);
  const Examples lights = read_examples(task, reader);
  const MatrixF examples = direct_irradiance(
      reader.scene(), reader.ray_caster(), samples, begin, begin + size, lights.positions,
      kNearest * samples_diagonal(shared_region(task, reader)->samples()));
  check_stop(reader);
  const VectorF areas = cluster_areas(samples, cluster);
  const MatrixF albedo = part->rows(reader.input(1)->matrix("albedo")).middleRows(begin, size);
  const MatrixF effect = patch_effect(*reader.input(2), *part, albedo, begin,
                                      task.parameters["near_share"].get<float>());
  check_stop(reader);
  EffectBasis basis;
  if (examples.rows() > 0) {
    basis = make_effect_basis(effect, examples, kMostPerRank * task.parameters["rank"].get<int>());
  }
  if (basis.functions.rows() == 0) add_constant(basis, areas);
  Artifact out;
  put_rows(out, basis);
  out.put("coefficients", sum_up(basis.projections * examples.transpose(), lights), "W/m^2",
          "example lights in the light functions");
  out.attributes = {{"cluster", number},
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

void put_projections(Artifact& out, const ClusterFunctions& projections) {
  out.put("projections", projections.values, "m^2/W",
          "coefficient = sum over a cluster's samples of projection times irradiance");
}

/// parts[c]: k_c × lights.
void put_coefficients(Artifact& out, const ClusterFunctions& functions,
                      const std::vector<MatrixF>& parts) {
  MatrixF lights(functions.count(), parts[0].cols());
  for (std::size_t c = 0; c < parts.size(); ++c) {
    lights.middleRows(functions.begin[c], functions.of(c)) = parts[c];
  }
  out.put("coefficients", lights, "1", "example lights in the functions of all clusters");
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
  const auto region = shared_region(task, reader);
  const SampleSet& samples = region->samples();
  std::vector<VectorF> strengths;
  for (std::size_t i = 1; i < own_inputs(task); ++i) {
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
  put_projections(out, collect(projections, samples));
  put_coefficients(out, all, coefficients);
  out.attributes = {{"functions", all.count()},
                    {"needless", shares.needless},
                    {"needless_effect", shares.needless_effect},
                    {"largest_rank", *std::max_element(kept.begin(), kept.end())}};
  return out;
}

namespace {

/// A region's functions, and which cluster of the scene has which of them.
struct RegionFunctions {
  RegionFunctions(const Artifact& artifact, const Region& region, const SampleSet& samples)
      : light(get_light_functions(artifact)), coefficients(artifact.matrix("coefficients")) {
    Eigen::Index row = 0;
    for (std::uint32_t k = 0; k < region.clusters.size(); ++k) {
      const Eigen::Index size = samples.cluster_size(region.clusters[k]);
      places[region.clusters[k]] = {k, row, size};
      row += size;
    }
  }
  struct Place {
    std::uint32_t cluster;  // in the region
    Eigen::Index row, rows;
  };
  /// Of one cluster: k × n_c.
  [[nodiscard]] MatrixF of(const MatrixF& values, const Place& p) const {
    return values.block(p.row, 0, p.rows, light.functions.of(p.cluster)).transpose();
  }
  [[nodiscard]] MatrixF coefficients_of(const Place& p) const {
    return coefficients.middleRows(light.functions.begin[p.cluster], light.functions.of(p.cluster));
  }
  LightFunctions light;
  MatrixF coefficients;
  std::map<std::uint32_t, Place> places;
};

}  // namespace

Artifact run_window_functions(const TaskSpec& task, const TaskReader& reader) {
  const auto part = shared_window(task, reader);
  const SampleSet& all = shared_samples(reader, 0)->samples;
  const std::vector<Region> regions = get_regions(*reader.input(task.inputs.size() - 1));
  std::vector<MatrixF> functions(part->clusters().size());
  std::vector<MatrixF> other(functions.size());
  const auto from = task.parameters["from"].get<std::vector<std::size_t>>();
  int needless = 0;
  double most_effect = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto bundle = reader.input(1 + i);
    needless += bundle->attribute<int>("needless");
    most_effect = std::max(most_effect, bundle->attribute<double>("needless_effect"));
    const RegionFunctions source(*bundle, regions.at(from[i]), all);
    for (const auto& [cluster, place] : source.places) {
      const std::uint32_t k = part->local(cluster);
      if (k == kNone) continue;
      functions[k] = source.of(source.light.functions.values, place);
      other[k] = part->is_whole() ? source.of(source.light.projections, place)
                                  : source.coefficients_of(place);
    }
  }
  Artifact out;
  const ClusterFunctions collected = collect(functions, part->samples());
  put_functions(out, collected);
  if (part->is_whole()) {
    put_projections(out, collect(other, part->samples()));
  } else {
    put_coefficients(out, collected, other);
  }
  out.attributes = {
      {"functions", collected.count()}, {"needless", needless}, {"needless_effect", most_effect}};
  return out;
}

Artifact run_snapshot_functions(const TaskSpec& task, const TaskReader& reader) {
  std::vector<MatrixF> functions;
  for (std::size_t i = 1; i < own_inputs(task); ++i) {
    functions.push_back(reader.input(i)->matrix("functions"));
  }
  Artifact out;
  put_functions(out, collect(functions, shared_window(task, reader)->samples()));
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
