#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/random.h"
#include "bases/function_basis.h"
#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/lb/near.h"
#include "methods/lb/scene_part.h"
#include "methods/lb/tasks.h"
#include "operators/reduced_system.h"
#include "transport/near_series.h"

namespace prt::lb {

namespace {

constexpr Eigen::Index kProbes = 4;
// Light shapes on a cluster are found from this many mixtures of lights per function wanted.
constexpr Eigen::Index kLightsPerRank = 6;
// Mixtures of example lights on which compressed transfer is tuned and judged.
constexpr Eigen::Index kTypicalLights = 250;
constexpr std::uint64_t kMixStream = 0x316875;

/// What the gather of one receiver cluster needs: inputs samples, albedo, rays. All numbers of
/// clusters and samples are those of the part of the scene that the task works on.
struct Receiver {
  Receiver(const TaskSpec& task, const TaskReader& reader)
      : part(shared_window(task, reader)),
        cluster(part->local(task.parameters["cluster"].get<std::uint32_t>())),
        rays(reader.input(2)),
        senders(part->local_senders(rays->values<std::uint32_t>("sender"))),
        directions(rays->attribute<int>("directions")),
        albedo(part->rows(
            reader.input(1)->matrix("albedo").leftCols(task.parameters["channels"].get<int>()))),
        areas(cluster_areas(part->samples(), cluster)) {}

  [[nodiscard]] std::vector<MatrixF> gather(const ClusterFunctions& functions) const {
    return gather_functions(senders, directions.weights(), albedo, functions,
                            part->cluster_of_sample());
  }
  /// Entries of the one-bounce operator above `least`.
  [[nodiscard]] GatherEntries entries(float least) const {
    return gather_entries(senders, directions.weights(), part->samples().size(), least);
  }
  /// This cluster's own functions, n_r × k.
  [[nodiscard]] MatrixF own(const ClusterFunctions& functions) const {
    return functions.values.block(part->samples().cluster_begin[cluster], 0,
                                  part->samples().cluster_size(cluster), functions.of(cluster));
  }
  /// The cluster's number in the scene.
  [[nodiscard]] std::uint32_t number() const { return part->clusters()[cluster]; }

  std::shared_ptr<const ScenePart> part;
  std::uint32_t cluster;
  std::shared_ptr<const Artifact> rays;
  std::vector<std::uint32_t> senders;
  HemisphereDirections directions;
  MatrixF albedo;
  VectorF areas;
};

void put_columns(Artifact& out, const ClusterFunctions& functions, const std::string& meaning) {
  out.put<std::uint32_t>("column_begin", functions.begin, {functions.begin.size()}, "1", meaning);
}

/// rows · parts, parts side by side: summed up in double, in slices, for a whole copy in double
/// would cost more than the product.
MatrixF project(const MatrixD& rows, const std::vector<MatrixF>& parts) {
  constexpr Eigen::Index kSlice = 128;
  const Eigen::Index width = parts[0].cols();
  MatrixF out(rows.rows(), width * static_cast<Eigen::Index>(parts.size()));
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (Eigen::Index first = 0; first < width; first += kSlice) {
      const Eigen::Index count = std::min(kSlice, width - first);
      const MatrixD slice = parts[p].middleCols(first, count).cast<double>();
      out.middleCols(static_cast<Eigen::Index>(p) * width + first, count) =
          MatrixD(rows * slice).cast<float>();
    }
  }
  return out;
}

/// The last example lights judge what the others made.
MatrixF probe_lights(const MatrixF& lights) {
  return lights.rightCols(std::min<Eigen::Index>(kProbes, lights.cols()));
}

/// All example lights but the probes, summed up with random signs into `most` columns (a count
/// sketch): bases made from them know every light, where so many of the lights alone would be
/// fitted too closely.
MatrixF training_lights(const MatrixF& lights, Eigen::Index most) {
  const Eigen::Index count = std::max<Eigen::Index>(1, lights.cols() - kProbes);
  MatrixF mixed = MatrixF::Zero(lights.rows(), std::min(most, count));
  for (Eigen::Index l = 0; l < count; ++l) {
    const bool negative = Random(kMixStream, static_cast<std::uint64_t>(l)).bits() % 2 == 1;
    mixed.col(l % mixed.cols()) += (negative ? -1.0F : 1.0F) * lights.col(l);
  }
  return mixed;
}

/// All bounces but the first of every light function, in the snapshot bases: input i is one
/// channel's solution, unknowns × functions.
std::shared_ptr<const MatrixF> shared_solution(const TaskReader& reader, std::size_t i) {
  return reader.memo().get<MatrixF>("solution " + reader.input_content(i).hex(), [&] {
    return std::make_shared<MatrixF>(reader.input(i)->matrix("solution"));
  });
}

/// That of lights instead of functions, the same for every receiver; `name` tells apart what was
/// made of one set of example lights (input 3).
std::shared_ptr<const MatrixF> shared_solved_lights(const TaskReader& reader, std::size_t i,
                                                    const MatrixF& lights,
                                                    const std::string& name) {
  return reader.memo().get<MatrixF>(
      "solution " + reader.input_content(i).hex() + " for " + name + " of " +
          reader.input_content(3).hex(),
      [&] { return std::make_shared<MatrixF>(*shared_solution(reader, i) * lights); });
}

}  // namespace

Artifact run_snapshot(const TaskSpec& task, const TaskReader& reader) {
  const Receiver receiver(task, reader);
  const auto functions = shared_functions(reader, 3);
  const std::vector<MatrixF> once = receiver.gather(*functions);
  check_stop(reader);
  const int rank = task.parameters["rank"].get<int>();
  const MatrixF lights =
      training_lights(*shared_light_coefficients(reader, 3), kLightsPerRank * rank);
  std::vector<MatrixF> shapes;
  shapes.reserve(2 * once.size());
  for (const MatrixF& x : once) shapes.emplace_back(x * lights);
  if (own_inputs(task) > 4) {
    const std::vector<MatrixF> gathered = receiver.gather(*shared_functions(reader, 4));
    const std::string name = fmt::format("snapshots of rank {}", rank);
    for (std::size_t c = 0; c < once.size(); ++c) {
      shapes.emplace_back(shapes[c] +
                          gathered[c] * *shared_solved_lights(reader, 5 + c, lights, name));
    }
  }
  const FunctionBasis basis = make_function_basis(side_by_side(shapes).transpose(), receiver.areas,
                                                  rank, task.parameters["tolerance"].get<double>());
  Artifact out;
  out.put("functions", basis.functions, "1/m", "basis of gathered light");
  const MatrixD weighted = (basis.functions * receiver.areas.asDiagonal()).cast<double>();
  out.put("projected", project(weighted, once), "W/m", "once-gathered light functions in it");
  put_columns(out, *functions, "first light function of each cluster of the part");
  out.attributes = {{"cluster", receiver.number()},   {"samples", receiver.areas.size()},
                    {"rank", basis.functions.rows()}, {"energy", basis.energy},
                    {"error", basis.error},           {"orthonormality_defect", basis.defect}};
  return out;
}

Artifact run_galerkin(const TaskSpec& task, const TaskReader& reader) {
  const Receiver receiver(task, reader);
  const auto snapshots = shared_functions(reader, 3);
  const MatrixD weighted_basis =
      (receiver.own(*snapshots).transpose() * receiver.areas.asDiagonal()).cast<double>();
  Artifact out;
  out.put("reduced", project(weighted_basis, receiver.gather(*snapshots)), "1",
          "rows of the reduced one-bounce operator, channels side by side");
  put_columns(out, *snapshots, "first snapshot function of each cluster of the part");
  out.attributes = {{"cluster", receiver.number()}};
  return out;
}

namespace {

/// One channel's rows of one cluster, columns by cluster of the part it was made in.
struct Rows {
  Rows(const Artifact& part, const std::string& name, Eigen::Index channel, Eigen::Index channels)
      : begin(part.vector<std::uint32_t>("column_begin")) {
    const MatrixF all = part.matrix(name);
    const Eigen::Index width = all.cols() / channels;
    values = all.middleCols(channel * width, width);
  }
  [[nodiscard]] Eigen::Index width(std::size_t k) const { return begin[k + 1] - begin[k]; }
  [[nodiscard]] auto of(std::size_t k) const { return values.middleCols(begin[k], width(k)); }
  std::vector<std::uint32_t> begin;
  MatrixF values;
};

/// The system of a region's window, or of the whole scene. Every cluster's rows were made in the
/// window of its own region: of those the columns that this window has, too, are taken.
class ReducedSystem {
 public:
  /// Without `reflects` only the right-hand side is read: light goes no farther than once.
  ReducedSystem(const TaskSpec& task, const TaskReader& reader, bool reflects)
      : regions_(shared_regions(task, reader)) {
    const std::size_t count = own_inputs(task) / (reflects ? 2 : 1);
    if (regions_->empty()) {
      clusters_.resize(count);
      std::iota(clusters_.begin(), clusters_.end(), 0U);
    } else {
      clusters_ = regions_->at(task.parameters["region"].get<std::size_t>()).window;
    }
    for (std::uint32_t k = 0; k < count; ++k) local_[clusters_[k]] = k;
    for (std::size_t r = 0; r < regions_->size(); ++r) {
      for (const std::uint32_t c : regions_->at(r).clusters) region_of_[c] = r;
    }
    const auto channels = task.parameters["channels"].get<Eigen::Index>();
    const auto channel = task.parameters["channel"].get<Eigen::Index>();
    std::vector<Rows> projected;
    std::vector<Rows> reduced;
    for (std::size_t k = 0; k < count; ++k) {
      projected.emplace_back(*reader.input(k), "projected", channel, channels);
      if (reflects) {
        reduced.emplace_back(*reader.input(count + k), "reduced", channel, channels);
      }
    }
    r = put_together(reduced);
    b = put_together(projected);
  }
  MatrixD r;  ///< unknowns × unknowns, or empty
  MatrixD b;  ///< unknowns × light functions

 private:
  /// Clusters of the part in which cluster k's rows were made.
  [[nodiscard]] const std::vector<std::uint32_t>& columns_of(std::size_t k) const {
    return regions_->empty() ? clusters_ : regions_->at(region_of_.at(clusters_[k])).window;
  }
  [[nodiscard]] Eigen::Index own_width(const Rows& rows, std::size_t k) const {
    const auto& columns = columns_of(k);
    const auto own = std::ranges::lower_bound(columns, clusters_[k]);
    return rows.width(static_cast<std::size_t>(own - columns.begin()));
  }
  MatrixD put_together(const std::vector<Rows>& parts) const {
    std::vector<Eigen::Index> column = {0};
    Eigen::Index height = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      column.push_back(column.back() + own_width(parts[k], k));
      height += parts[k].values.rows();
    }
    MatrixD all = MatrixD::Zero(height, column.back());
    Eigen::Index row = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const auto& columns = columns_of(k);
      for (std::size_t j = 0; j < columns.size(); ++j) {
        const auto found = local_.find(columns[j]);
        if (found == local_.end()) continue;
        const auto block = parts[k].of(j);
        all.block(row, column[found->second], block.rows(), block.cols()) = block.cast<double>();
      }
      row += parts[k].values.rows();
    }
    return all;
  }

  std::shared_ptr<const std::vector<Region>> regions_;
  std::vector<std::uint32_t> clusters_;  // the scene's numbers of the system's clusters
  std::map<std::uint32_t, std::uint32_t> local_;
  std::map<std::uint32_t, std::size_t> region_of_;
};

}  // namespace

Artifact run_solve(const TaskSpec& task, const TaskReader& reader) {
  const int bounces = task.parameters["bounces"].get<int>();
  // X itself is the first bounce and U·x what T sends on, so N bounces need N − 2 powers of R.
  const int powers = bounces < 0 ? -1 : std::max(0, bounces - 2);
  ReducedSystem system(task, reader, powers != 0);
  check_stop(reader);
  const ReducedSolution solved =
      powers != 0 ? blaming_the_scene([&] { return solve_reduced(system.r, system.b, powers); })
                  : ReducedSolution{system.b, 0.0};
  Artifact out;
  out.put("solution", MatrixF(solved.x.cast<float>()), "W/m",
          "all bounces of every light function in the snapshot bases, one channel");
  out.attributes = {{"channel", task.parameters["channel"].get<int>()},
                    {"unknowns", system.b.rows()},
                    {"reduced_residual", solved.residual}};
  return out;
}

namespace {

/// From here on senders have the scene's numbers.
void name_senders(Artifact& out, const ScenePart& part) {
  std::vector<std::uint32_t> senders = out.vector<std::uint32_t>("senders");
  for (std::uint32_t& s : senders) s = part.clusters()[s];
  Dataset& dataset = out.datasets.at("senders");
  const auto bytes = std::as_bytes(std::span(senders));
  dataset.bytes.assign(bytes.begin(), bytes.end());
}

}  // namespace

Artifact run_transfer(const TaskSpec& task, const TaskReader& reader) {
  const Receiver receiver(task, reader);
  const auto functions = shared_functions(reader, 3);
  std::vector<MatrixF> once = receiver.gather(*functions);
  const std::size_t channels = once.size();
  const auto coefficients = shared_light_coefficients(reader, 3);
  const MatrixF z = probe_lights(*coefficients);
  const MatrixF typical = training_lights(*coefficients, kTypicalLights);
  double source = 0.0;  // squared norm of the once-gathered probes
  std::vector<MatrixF> lit;
  for (const MatrixF& x : once) {
    lit.emplace_back(x * z);
    source += (receiver.areas.cwiseSqrt().asDiagonal() * lit.back()).squaredNorm();
  }
  const std::size_t first_near = 4;
  const SampleSet& samples = receiver.part->samples();
  const std::size_t first_bounces = first_near + samples.clusters();
  check_stop(reader);
  const auto& p = task.parameters;
  subtract_series(
      near_series(*shared_near(reader, first_near, *receiver.part), receiver.albedo,
                  samples.cluster_begin[receiver.cluster],
                  samples.cluster_begin[receiver.cluster + 1], p["near_bounces"].get<int>()),
      *functions, receiver.part->cluster_of_sample(), once);
  std::vector<ChannelTransfer> transfer(channels);
  std::vector<MatrixF> fields;
  for (std::size_t c = 0; c < channels; ++c) {
    transfer[c].once = std::move(once[c]);
    fields.emplace_back(transfer[c].once * typical);
  }
  MatrixF probes =
      MatrixF::Zero(receiver.areas.size(), static_cast<Eigen::Index>(channels) * z.cols());
  if (own_inputs(task) > first_bounces) {
    check_stop(reader);
    const auto snapshots = shared_functions(reader, first_bounces);
    std::vector<MatrixF> gathered = receiver.gather(*snapshots);
    const MatrixF own = receiver.own(*snapshots);
    const MatrixF lights = side_by_side({z, typical});
    for (std::size_t c = 0; c < channels; ++c) {
      const std::size_t solved = first_bounces + 1 + c;
      transfer[c].further = std::move(gathered[c]);
      transfer[c].solution = shared_solution(reader, solved);
      const MatrixF bounced =
          transfer[c].further * *shared_solved_lights(reader, solved, lights, "probes and typical");
      lit[c] += bounced.leftCols(z.cols());
      fields[c] += bounced.rightCols(typical.cols());
      // The part of the probes that the snapshot bases miss: T sends exactly that on as residual.
      probes.middleCols(static_cast<Eigen::Index>(c) * z.cols(), z.cols()) =
          lit[c] - own * (own.transpose() * (receiver.areas.asDiagonal() * lit[c]));
    }
  }
  check_stop(reader);
  Artifact out =
      compress_transfer(transfer, fields, receiver.areas, functions->begin, typical,
                        {p["bits"].get<int>(), p["rank"].get<int>(), p["tolerance"].get<double>()});
  name_senders(out, *receiver.part);
  out.put("probes", probes, "W/m^2", "probe lights' part outside the snapshot bases");
  out.attributes["cluster"] = receiver.number();
  out.attributes["samples"] = receiver.areas.size();
  out.attributes["probe_source"] = source;
  out.attributes["near_bounces"] = p["near_bounces"].get<int>();  // as parsed, its sign would vary
  return out;
}

Artifact run_residual(const TaskSpec& task, const TaskReader& reader) {
  const Receiver receiver(task, reader);
  const auto channels = task.parameters["channels"].get<int>();
  const Eigen::Index lights =
      static_cast<Eigen::Index>(reader.input(3)->at("probes").dims.at(1)) / channels;
  const auto samples = static_cast<Eigen::Index>(receiver.part->samples().size());
  std::vector<MatrixF> fields(channels, MatrixF(samples, lights));
  Eigen::Index row = 0;
  for (std::size_t i = 3; i < own_inputs(task); ++i) {
    const auto part = reader.input(i);
    const MatrixF probes = part->matrix("probes");
    for (int c = 0; c < channels; ++c) {
      fields[c].middleRows(row, probes.rows()) = probes.middleCols(c * lights, lights);
    }
    row += probes.rows();
  }
  const auto residual = gather_fields(receiver.entries(0.0F), receiver.albedo, fields);
  double squared = 0.0;
  for (const MatrixF& r : residual) {
    squared += (receiver.areas.cwiseSqrt().asDiagonal() * r).squaredNorm();
  }
  Artifact out;
  out.attributes = {
      {"cluster", receiver.number()},
      {"squared_residual", squared},
      {"squared_source", reader.input(3 + receiver.cluster)->attribute<double>("probe_source")}};
  return out;
}

}  // namespace prt::lb
