#include "methods/lb/scene_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "domains/directions.h"
#include "transport/hemisphere.h"

namespace prt::lb {

namespace {

std::vector<std::uint32_t> all_clusters(std::size_t count) {
  std::vector<std::uint32_t> clusters(count);
  std::iota(clusters.begin(), clusters.end(), 0U);
  return clusters;
}

SampleSet samples_of(const SampleSet& all, const std::vector<std::uint32_t>& clusters) {
  SampleSet part;
  part.cluster_begin = {0};
  const auto append = [](auto& to, const auto& from, std::uint32_t first, std::uint32_t end) {
    if (!from.empty()) to.insert(to.end(), from.begin() + first, from.begin() + end);
  };
  for (const std::uint32_t c : clusters) {
    const std::uint32_t first = all.cluster_begin[c];
    const std::uint32_t end = all.cluster_begin[c + 1];
    append(part.positions, all.positions, first, end);
    append(part.normals, all.normals, first, end);
    append(part.tangents, all.tangents, first, end);
    append(part.areas, all.areas, first, end);
    append(part.radii, all.radii, first, end);
    append(part.triangles, all.triangles, first, end);
    part.cluster_begin.push_back(part.cluster_begin.back() + end - first);
  }
  return part;
}

using Lists = std::vector<std::vector<std::uint32_t>>;

void put_lists(Artifact& out, const std::string& name, const Lists& lists,
               const std::string& meaning) {
  std::vector<std::uint32_t> begin = {0};
  std::vector<std::uint32_t> flat;
  for (const auto& list : lists) {
    flat.insert(flat.end(), list.begin(), list.end());
    begin.push_back(static_cast<std::uint32_t>(flat.size()));
  }
  out.put<std::uint32_t>(name + "_begin", begin, {begin.size()}, "1", "first entry of each region");
  out.put<std::uint32_t>(name, flat, {flat.size()}, "1", meaning);
}

Lists get_lists(const Artifact& artifact, const std::string& name) {
  const auto begin = artifact.values<std::uint32_t>(name + "_begin");
  const auto flat = artifact.values<std::uint32_t>(name);
  if (begin.empty() || begin.front() != 0 || begin.back() != flat.size() ||
      !std::is_sorted(begin.begin(), begin.end())) {
    throw UnsoundData("the arrays of the windows do not fit together");
  }
  Lists lists;
  for (std::size_t r = 0; r + 1 < begin.size(); ++r) {
    lists.emplace_back(flat.begin() + begin[r], flat.begin() + begin[r + 1]);
  }
  return lists;
}

using ClustersOf = std::vector<std::uint32_t> Region::*;

std::shared_ptr<const ScenePart> shared_part(const TaskSpec& task, const TaskReader& reader,
                                             ClustersOf clusters, const std::string& what) {
  const auto scene = shared_samples(reader, 0);
  const std::string name = "part of samples " + reader.input_content(0).hex();
  if (!task.parameters.contains("region")) {
    return reader.memo().get<ScenePart>(name, [&] { return std::make_shared<ScenePart>(scene); });
  }
  const auto region = task.parameters["region"].get<std::size_t>();
  const std::string part = fmt::format("{}: {} {} of {}", name, what, region,
                                       reader.input_content(task.inputs.size() - 1).hex());
  return reader.memo().get<ScenePart>(part, [&] {
    return std::make_shared<ScenePart>(scene, shared_regions(task, reader)->at(region).*clusters);
  });
}

}  // namespace

ScenePart::ScenePart(std::shared_ptr<const SharedSamples> scene)
    : scene_(std::move(scene)),
      own_(scene_),
      clusters_(all_clusters(scene_->samples.clusters())),
      local_(clusters_) {}

ScenePart::ScenePart(std::shared_ptr<const SharedSamples> scene,
                     std::vector<std::uint32_t> clusters)
    : scene_(std::move(scene)),
      own_(std::make_shared<SharedSamples>(samples_of(scene_->samples, clusters))),
      clusters_(std::move(clusters)),
      local_(scene_->samples.clusters(), kNone) {
  for (std::uint32_t k = 0; k < clusters_.size(); ++k) local_[clusters_[k]] = k;
}

std::uint32_t ScenePart::local_sample(std::uint32_t sample) const {
  const std::uint32_t cluster = scene_->cluster_of_sample[sample];
  const std::uint32_t k = local_[cluster];
  if (k == kNone) return kNone;
  return own_->samples.cluster_begin[k] + sample - scene_->samples.cluster_begin[cluster];
}

MatrixF ScenePart::rows(MatrixF of_scene) const {
  if (is_whole()) return of_scene;
  MatrixF part(static_cast<Eigen::Index>(samples().size()), of_scene.cols());
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    const std::uint32_t first = scene_->samples.cluster_begin[clusters_[k]];
    part.middleRows(samples().cluster_begin[k], samples().cluster_size(k)) =
        of_scene.middleRows(first, samples().cluster_size(k));
  }
  return part;
}

std::vector<std::uint32_t> ScenePart::local_senders(std::span<const std::uint32_t> senders) const {
  std::vector<std::uint32_t> hits(senders.begin(), senders.end());
  if (is_whole()) return hits;
  for (std::uint32_t& s : hits) {
    if (s >= kLostSender) continue;
    s = local_sample(s);
    if (s == kNone) s = kLostSender;
  }
  return hits;
}

std::size_t own_inputs(const TaskSpec& task) {
  return task.inputs.size() - (task.parameters.contains("region") ? 1 : 0);
}

std::vector<Region> get_regions(const Artifact& artifact) {
  const Lists clusters = get_lists(artifact, "regions");
  const Lists windows = get_lists(artifact, "windows");
  if (clusters.size() != windows.size()) {
    throw UnsoundData("the arrays of the windows do not fit together");
  }
  std::vector<Region> regions;
  for (std::size_t r = 0; r < clusters.size(); ++r) {
    regions.push_back({clusters[r], windows[r], 0.0});
  }
  return regions;
}

Artifact put_regions(const std::vector<Region>& regions, double gain) {
  Lists clusters;
  Lists windows;
  std::vector<double> left_out;
  std::size_t largest = 0;
  double total = 0.0;
  for (const Region& region : regions) {
    clusters.push_back(region.clusters);
    windows.push_back(region.window);
    left_out.push_back(region.left_out);
    largest = std::max(largest, region.window.size());
    total += static_cast<double>(region.window.size());
  }
  Artifact out;
  put_lists(out, "regions", clusters, "clusters that are solved for together");
  put_lists(out, "windows", windows, "clusters whose light counts in a region");
  out.put<double>(
      "left_out", left_out, {left_out.size()}, "1",
      "share of a uniformly lit region's indirect light that comes from outside its window");
  out.attributes = {{"regions", regions.size()},
                    {"largest_window", largest},
                    {"mean_window", total / static_cast<double>(regions.size())},
                    {"gain", gain},
                    {"error", *std::ranges::max_element(left_out)}};
  return out;
}

std::shared_ptr<const std::vector<Region>> shared_regions(const TaskSpec& task,
                                                          const TaskReader& reader) {
  if (!task.parameters.contains("region")) {
    return std::make_shared<std::vector<Region>>();
  }
  const std::size_t last = task.inputs.size() - 1;
  return reader.memo().get<std::vector<Region>>("regions " + reader.input_content(last).hex(), [&] {
    return std::make_shared<std::vector<Region>>(get_regions(*reader.input(last)));
  });
}

std::shared_ptr<const ScenePart> shared_window(const TaskSpec& task, const TaskReader& reader) {
  return shared_part(task, reader, &Region::window, "window");
}

std::shared_ptr<const ScenePart> shared_region(const TaskSpec& task, const TaskReader& reader) {
  return shared_part(task, reader, &Region::clusters, "region");
}

Artifact run_reach(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto rays = reader.input(1);
  const HemisphereDirections directions(rays->attribute<int>("directions"));
  const auto cluster = task.parameters["cluster"].get<std::uint32_t>();
  const VectorD areas = cluster_areas(shared->samples, cluster).cast<double>();
  const auto hits = rays->values<std::uint32_t>("sender");
  const auto count = static_cast<std::size_t>(directions.count());
  VectorD share = VectorD::Zero(static_cast<Eigen::Index>(shared->samples.clusters()));
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i] >= kLostSender) continue;
    share[shared->cluster_of_sample[hits[i]]] +=
        areas[static_cast<Eigen::Index>(i / count)] * directions.weights()[i % count];
  }
  share /= areas.sum();
  std::vector<std::uint32_t> senders;
  std::vector<float> shares;
  for (Eigen::Index s = 0; s < share.size(); ++s) {
    if (share[s] == 0.0) continue;
    senders.push_back(static_cast<std::uint32_t>(s));
    shares.push_back(static_cast<float>(share[s]));
  }
  Artifact out;
  out.put<std::uint32_t>("senders", senders, {senders.size()}, "1", "clusters that are seen");
  out.put<float>("shares", shares, {shares.size()}, "1",
                 "cosine-weighted share of the cluster's hemispheres that each fills");
  out.attributes = {{"cluster", cluster}, {"senders", senders.size()}, {"seen", share.sum()}};
  return out;
}

namespace {

/// Albedo of each cluster, the largest channel's, in the mean over its area.
VectorD cluster_albedo(const SampleSet& samples, const MatrixF& albedo, const VectorD& areas) {
  VectorD mean = VectorD::Zero(areas.size());
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (std::uint32_t s = samples.cluster_begin[c]; s < samples.cluster_begin[c + 1]; ++s) {
      sum += samples.areas[s] * albedo.row(s).cast<double>();
    }
    mean[static_cast<Eigen::Index>(c)] = sum.maxCoeff() / areas[static_cast<Eigen::Index>(c)];
  }
  return mean;
}

}  // namespace

Artifact run_windows(const TaskSpec& task, const TaskReader& reader) {
  const SampleSet& samples = shared_samples(reader, 0)->samples;
  ClusterExchange exchange;
  exchange.begin = {0};
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const auto part = reader.input(2 + c);
    const auto senders = part->values<std::uint32_t>("senders");
    const auto shares = part->values<float>("shares");
    exchange.senders.insert(exchange.senders.end(), senders.begin(), senders.end());
    exchange.shares.insert(exchange.shares.end(), shares.begin(), shares.end());
    exchange.begin.push_back(static_cast<std::uint32_t>(exchange.senders.size()));
  }
  VectorD areas(static_cast<Eigen::Index>(samples.clusters()));
  for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
    areas[c] = cluster_areas(samples, c).cast<double>().sum();
  }
  const auto& p = task.parameters;
  const VectorD albedo = cluster_albedo(samples, reader.input(1)->matrix("albedo"), areas);
  const VectorD lit = uniform_irradiance(exchange, albedo);
  const auto regions = make_regions(cluster_centres(samples.positions, samples.cluster_begin),
                                    p["region_clusters"].get<std::size_t>());
  return put_regions(
      find_windows(regions, exchange, albedo, areas, lit,
                   {p["tolerance"].get<double>(), p["most_clusters"].get<std::size_t>()}),
      lit.maxCoeff());
}

}  // namespace prt::lb
