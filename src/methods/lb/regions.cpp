#include "methods/lb/regions.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <set>

#include "methods/common/inputs.h"
#include "methods/lb/scene_part.h"

namespace prt::lb {

std::size_t most_region_clusters(const OptionValues& options, std::size_t clusters) {
  if (options.get<std::string>("lb.solver") == "photons") return clusters;
  if (!options.is_auto("lb.region_clusters")) {
    return options.get<std::size_t>("lb.region_clusters");
  }
  return clusters <= kWholeClusters ? clusters : kRegionClusters;
}

std::size_t most_window_clusters(std::size_t most_region_clusters) {
  return std::max(kWindowClusters, 3 * most_region_clusters);
}

std::vector<std::string> cluster_places(const Artifact& samples, std::size_t most) {
  const auto begin = samples.values<std::uint32_t>("cluster_begin");
  const std::size_t clusters = begin.size() - 1;
  std::vector<std::string> places(clusters);
  if (clusters <= most) {
    for (std::size_t c = 0; c < clusters; ++c) places[c] = cluster_place(c);
    return places;
  }
  const auto regions = make_regions(cluster_centres(samples.points("position"), begin), most);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    for (const std::uint32_t c : regions[r]) places[c] = Regions::place(r);
  }
  return places;
}

std::vector<std::string> numbered_all(const std::string& stage,
                                      const std::vector<std::uint32_t>& clusters) {
  std::vector<std::string> ids;
  ids.reserve(clusters.size());
  for (const std::uint32_t c : clusters) ids.push_back(numbered(stage, c));
  return ids;
}

Regions::Regions(std::vector<Region> regions, std::size_t clusters)
    : regions_(std::move(regions)), region_of_(clusters, 0) {
  for (std::size_t r = 0; r < regions_.size(); ++r) {
    for (const std::uint32_t c : regions_[r].clusters) region_of_[c] = r;
  }
}

Regions Regions::whole(std::size_t clusters) {
  Region all;
  all.clusters.resize(clusters);
  std::iota(all.clusters.begin(), all.clusters.end(), 0U);
  all.window = all.clusters;
  return {{all}, clusters};
}

std::string Regions::name(const std::string& stage, std::size_t r) const {
  return several() ? numbered(stage, r) : stage;
}

std::string Regions::light_functions(std::size_t r) const {
  return several() ? numbered("window_functions", r) : "light_functions";
}

std::string Regions::place(std::size_t r) { return numbered("region", r); }

void Regions::place(TaskSpec& spec, std::size_t r) const {
  if (!several()) return;
  spec.parameters["region"] = r;
  spec.place = place(r);  // its tasks read the same window
  spec.inputs.emplace_back(kWindowsTask);
}

std::vector<std::vector<std::size_t>> Regions::lit_by() const {
  std::vector<std::vector<std::size_t>> regions(region_of_.size());
  for (std::size_t r = 0; r < count(); ++r) {
    for (const std::uint32_t c : regions_[r].window) regions[c].push_back(r);
  }
  return regions;
}

std::size_t Regions::lights(std::size_t wanted, std::size_t least) const {
  if (!several()) return wanted;
  std::size_t windows = 0;
  for (const Region& region : regions_) windows += region.window.size();
  assert(windows > 0);  // a region is in its own window
  return std::min(wanted, std::max(least, wanted * region_of_.size() / windows));
}

std::vector<std::size_t> Regions::in_window(std::size_t r) const {
  std::set<std::size_t> regions;
  for (const std::uint32_t c : regions_[r].window) regions.insert(of(c));
  return {regions.begin(), regions.end()};
}

}  // namespace prt::lb
