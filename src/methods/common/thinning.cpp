#include "methods/common/thinning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "base/random.h"
#include "domains/clusters.h"
#include "domains/thinning.h"
#include "domains/tiles.h"
#include "methods/common/inputs.h"
#include "store/samples_io.h"
#include "transport/area_points.h"
#include "transport/particles.h"

namespace prt {

namespace {

// Distances to a tile are rounded.
constexpr float kHaloSlack = 1e-3F;
// Area points by which tiles are made alike.
constexpr std::uint64_t kPointsPerTile = 64;
// Candidates of high priority: the sixteenth that is looked for, and so many standard deviations.
constexpr double kHighestShare = 1.0 / 16.0;
constexpr double kDeviations = 8.0;

std::uint64_t stream_of(const TaskSpec& task) {
  return stream_key(task.parameters["seed"].get<std::uint64_t>(), "thinning");
}

std::uint64_t priority_of(std::uint64_t stream, std::uint32_t number) {
  Random random(stream, number);
  const std::uint64_t high = random.bits();
  return high << 32 | random.bits();
}

/// Candidates, by rising number among all.
struct CandidateSet {
  SurfacePoints points;
  std::vector<std::uint32_t> numbers;
  std::vector<float> curvatures;
  std::vector<std::uint64_t> priorities;

  [[nodiscard]] std::size_t size() const { return points.size(); }
  [[nodiscard]] Candidates view() const {
    return {points.positions, points.normals, curvatures, priorities};
  }
  void add(const CandidateSet& from, std::size_t i) {
    points.positions.push_back(from.points.positions[i]);
    points.normals.push_back(from.points.normals[i]);
    points.triangles.push_back(from.points.triangles[i]);
    numbers.push_back(from.numbers[i]);
  }
  void weigh(const Scene& scene, std::uint64_t stream) {
    for (std::size_t i = 0; i < size(); ++i) {
      curvatures.push_back(triangle_curvature(scene, points.triangles[i]));
      priorities.push_back(priority_of(stream, numbers[i]));
    }
  }
};

CandidateSet sorted_by_number(const CandidateSet& set) {
  std::vector<std::uint32_t> order(set.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return set.numbers[i]; });
  CandidateSet sorted;
  for (const std::uint32_t i : order) sorted.add(set, i);
  return sorted;
}

/// `among`: what their numbers count.
void put_candidates(Artifact& out, const CandidateSet& set, const std::string& among = "all") {
  out.put("position", set.points.positions, "m", "candidate positions");
  out.put("normal", set.points.normals, "1", "unit geometric normals on the side hit");
  out.put<std::uint32_t>("triangle", set.points.triangles, {set.size()}, "1", "triangle hit");
  out.put<std::uint32_t>("number", set.numbers, {set.size()}, "1",
                         "the candidate's number among " + among);
}

/// Candidates as the stages after "candidates" write them, their numbers `first` higher.
CandidateSet get_candidates(const Artifact& part, std::uint32_t first) {
  CandidateSet set;
  set.points = {part.points("position"), part.points("normal"),
                part.vector<std::uint32_t>("triangle")};
  for (const auto n : part.values<std::uint32_t>("number")) set.numbers.push_back(first + n);
  return set;
}

/// A box around points.
struct Bounds {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
  void include(const Vec3f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void include(const Artifact& artifact) {
    const std::vector<Vec3f> box = artifact.points("bounds");
    if (box.size() != 2)
      throw UnsoundData("the box around a group of candidates has no two corners");
    low = low.cwiseMin(box[0]);  // side by side: the box of no candidates is inside out
    high = high.cwiseMax(box[1]);
  }
  void put(Artifact& out) const {
    out.put("bounds", std::vector<Vec3f>{low, high}, "m", "corners of the box around all");
  }
};

std::shared_ptr<const Tiles> shared_tiles(const TaskReader& reader, const nlohmann::json& p) {
  const auto count = p["tiles"].get<std::uint64_t>();
  const std::uint64_t stream = stream_key(p["seed"].get<std::uint64_t>(), "tiles");
  return reader.memo().get<Tiles>(fmt::format("{} tiles {}", count, stream), [&] {
    const std::vector<double> cumulative = cumulative_areas(reader.scene());
    std::vector<Vec3f> points;
    for (std::uint64_t k = 0; k < kPointsPerTile * count; ++k) {
      Random random(stream, k);
      const auto [t, u, v] = area_point(cumulative, k, kPointsPerTile * count, stream, random);
      points.push_back(triangle_point(reader.scene(), t, u, v));
    }
    return std::make_shared<Tiles>(std::move(points), count);
  });
}

/// Those of a group's candidates that lie in one of some tiles or near it.
Artifact run_tiles(const TaskSpec& task, const TaskReader& reader) {
  const auto& p = task.parameters;
  const auto tiles = shared_tiles(reader, p);
  const auto halo = p["halo"].get<float>();
  const auto first = p["first"].get<std::size_t>();
  const auto end = first + p["count"].get<std::size_t>();
  CandidateSet near;
  Bounds bounds;
  std::uint32_t total = 0;
  for (std::size_t i = 0; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i);
    CandidateSet all;
    all.points = {part->points("position"), part->points("normal"),
                  part->vector<std::uint32_t>("triangle")};
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Vec3f& position = all.points.positions[k];
      all.numbers.push_back(total++);
      bounds.include(position);
      bool is_near = false;
      for (std::size_t t = first; t < end && !is_near; ++t) {
        is_near = tiles->distance(t, position) <= halo;
      }
      if (is_near) near.add(all, k);
    }
  }
  Artifact out;
  put_candidates(out, near, "those of the task's inputs");
  bounds.put(out);
  out.attributes["candidates"] = total;
  return out;
}

/// A tile's candidates from the inputs after the first few, and how many there are everywhere.
struct TileCandidates {
  CandidateSet set;
  Bounds bounds;
  std::uint32_t total = 0;
};
template <typename Accept>
TileCandidates read_tile(const TaskSpec& task, const TaskReader& reader, std::size_t skip,
                         Accept&& accept) {
  TileCandidates tile;
  for (std::size_t i = skip; i < task.inputs.size(); ++i) {
    const auto group = reader.input(i);
    const CandidateSet candidates = get_candidates(*group, tile.total);
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (accept(candidates.points.positions[k])) tile.set.add(candidates, k);
    }
    tile.total += group->attribute<std::uint32_t>("candidates");
    tile.bounds.include(*group);
  }
  return tile;
}

/// The tile's candidates that are, or might be, among the sixteenth of highest priority.
Artifact run_highest(const TaskSpec& task, const TaskReader& reader) {
  const auto tiles = shared_tiles(reader, task.parameters);
  const auto t = task.parameters["tile"].get<std::size_t>();
  const TileCandidates tile =
      read_tile(task, reader, 0, [&](const Vec3f& p) { return tiles->contains(t, p); });
  const double share =
      kHighestShare + kDeviations * std::sqrt(kHighestShare / std::max(1.0, 1.0 * tile.total));
  const double lowest = std::max(0.0, (1.0 - share) * 0x1p64);
  CandidateSet high;
  for (std::size_t i = 0; i < tile.set.size(); ++i) {
    const std::uint64_t priority = priority_of(stream_of(task), tile.set.numbers[i]);
    if (static_cast<double>(priority) >= lowest) high.add(tile.set, i);
  }
  Artifact out;
  put_candidates(out, high);
  tile.bounds.put(out);
  out.attributes["candidates"] = tile.total;
  return out;
}

void check_any(std::size_t candidates) {
  if (candidates > 0) return;
  throw UserError(
      "samples.start: no particle from the start point met a surface; give a start point [x, y, z] "
      "from which the scene is seen");
}

/// Candidates of several tiles.
CandidateSet gather(const TaskReader& reader, std::size_t first, std::size_t end) {
  CandidateSet set;
  for (std::size_t i = first; i < end; ++i) {
    const CandidateSet part = get_candidates(*reader.input(i), 0);
    set.points.append(part.points);
    set.numbers.insert(set.numbers.end(), part.numbers.begin(), part.numbers.end());
  }
  return sorted_by_number(set);
}

/// The radius with which the search begins, and the range in which it should stay.
Artifact run_spacing(const TaskSpec& task, const TaskReader& reader) {
  CandidateSet high = gather(reader, 0, task.inputs.size());
  high.weigh(reader.scene(), stream_of(task));
  Bounds bounds;
  bounds.include(*reader.input(0));
  const float extent = (bounds.high - bounds.low).norm();
  const auto total = reader.input(0)->attribute<std::size_t>("candidates");
  check_any(total);
  const RadiusGuess guess = guess_radius(
      high.view(), total, extent, task.parameters["count"].get<std::size_t>(), kCompatibleCosine);
  Artifact out;
  out.attributes["first"] = guess.first;
  out.attributes["low"] = guess.range.low;
  out.attributes["high"] = guess.range.high;
  return out;
}

RadiusGuess guess_of(const Artifact& spacing) {
  return {spacing.attribute<float>("first"),
          {spacing.attribute<float>("low"), spacing.attribute<float>("high")}};
}

/// Of a tile, those that some radius of the range may keep.
Artifact run_thin(const TaskSpec& task, const TaskReader& reader) {
  const auto& p = task.parameters;
  const auto tiles = shared_tiles(reader, p);
  const auto t = p["tile"].get<std::size_t>();
  const auto halo = p["halo"].get<float>();
  const bool is_known = p.contains("spacing");
  const RadiusRange range = is_known
                                ? RadiusRange{p["spacing"].get<float>(), p["spacing"].get<float>()}
                                : guess_of(*reader.input(0)).range;
  TileCandidates tile = read_tile(task, reader, is_known ? 0 : 1, [&](const Vec3f& position) {
    return tiles->distance(t, position) <= halo;
  });
  tile.set.weigh(reader.scene(), stream_of(task));
  std::vector<float> known;
  for (const Vec3f& position : tile.set.points.positions) {
    known.push_back((1.0F - kHaloSlack) * halo - tiles->distance(t, position));
  }
  CandidateSet left;
  for (const auto i : drop_beaten(tile.set.view(), known, range, kCompatibleCosine)) {
    if (tiles->contains(t, tile.set.points.positions[i])) left.add(tile.set, i);
  }
  Artifact out;
  put_candidates(out, left);
  out.attributes["candidates"] = tile.total;
  return out;
}

CandidateSet all_candidates(const TaskSpec& task, const TaskReader& reader, std::size_t first) {
  CandidateSet all;
  for (std::size_t i = first; i < task.inputs.size(); ++i) {
    const auto part = reader.input(i);
    all.points.append({part->points("position"), part->points("normal"),
                       part->vector<std::uint32_t>("triangle")});
  }
  all.numbers.resize(all.points.size());
  std::iota(all.numbers.begin(), all.numbers.end(), 0U);
  all.weigh(reader.scene(), stream_of(task));
  return all;
}

/// Candidates that stay, and among which they were chosen.
struct Thinned {
  CandidateSet set;
  ThinnedTo to;
  std::size_t candidates = 0;
};

Thinned thin_all(const TaskSpec& task, const TaskReader& reader, std::size_t first) {
  const auto& p = task.parameters;
  Thinned thinned;
  thinned.set = all_candidates(task, reader, first);
  thinned.candidates = thinned.set.size();
  if (p.contains("spacing")) {
    thinned.to.radius = p["spacing"].get<float>();
    thinned.to.kept = thin(thinned.set.view(), thinned.to.radius, kCompatibleCosine);
  } else {
    thinned.to =
        thin_to_count(thinned.set.view(), p["count"].get<std::size_t>(), kCompatibleCosine);
  }
  return thinned;
}

/// From what the tiles left; from all candidates, which are read only then, where that does not do.
Thinned thin_tiles(const TaskSpec& task, const TaskReader& reader) {
  const auto& p = task.parameters;
  const std::size_t first = p.contains("spacing") ? 0 : 1;
  const std::size_t end = first + p["tiles"].get<std::size_t>();
  Thinned thinned;
  thinned.set = gather(reader, first, end);
  thinned.set.weigh(reader.scene(), stream_of(task));
  thinned.candidates = reader.input(first)->attribute<std::size_t>("candidates");
  if (p.contains("spacing")) {
    thinned.to.radius = p["spacing"].get<float>();
    thinned.to.kept = thin(thinned.set.view(), thinned.to.radius, kCompatibleCosine);
    return thinned;
  }
  auto to = thin_to_count(thinned.set.view(), guess_of(*reader.input(0)),
                          p["count"].get<std::size_t>(), kCompatibleCosine);
  if (!to) return thin_all(task, reader, end);
  thinned.to = std::move(*to);
  return thinned;
}

LooseSamples kept_samples(const Thinned& thinned) {
  LooseSamples loose;
  const CandidateSet& set = thinned.set;
  for (const auto i : thinned.to.kept) {
    loose.positions.push_back(set.points.positions[i]);
    loose.normals.push_back(set.points.normals[i]);
    loose.triangles.push_back(set.points.triangles[i]);
    loose.radii.push_back(candidate_radius(thinned.to.radius, set.curvatures[i]));
    loose.priorities.push_back(set.priorities[i]);
  }
  return loose;
}

Artifact run_points(const TaskSpec& task, const TaskReader& reader) {
  const bool in_tiles = task.parameters.contains("tiles");
  const Thinned thinned = in_tiles ? thin_tiles(task, reader) : thin_all(task, reader, 0);
  check_any(thinned.candidates);
  const ClusteredSamples clustered =
      cluster_samples(kept_samples(thinned), task.parameters["cluster_size"].get<std::size_t>());
  Artifact out;
  put_samples(out, clustered.samples);
  out.put<std::uint32_t>("root", clustered.roots, {clustered.roots.size()}, "1",
                         "the sample that is each cluster's root point");
  out.attributes["samples"] = clustered.samples.size();
  out.attributes["clusters"] = clustered.samples.clusters();
  out.attributes["spacing"] = thinned.to.radius;
  out.attributes["candidates"] = thinned.candidates;
  return out;
}

}  // namespace

std::vector<std::string> thinning_kinds() {
  return {"tiles", "highest", "spacing", "thin", "points"};
}

Artifact run_thinning(const TaskSpec& task, const TaskReader& reader) {
  if (task.kind == "tiles") return run_tiles(task, reader);
  if (task.kind == "highest") return run_highest(task, reader);
  if (task.kind == "spacing") return run_spacing(task, reader);
  if (task.kind == "thin") return run_thin(task, reader);
  if (task.kind == "points") return run_points(task, reader);
  throw std::logic_error("no thinning task: " + task.kind);
}

}  // namespace prt
