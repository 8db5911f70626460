#include "package/write.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/atomic_file.h"
#include "package/extension.h"
#include "package/gltf_writer.h"
#include "package/matrix_list.h"
#include "package/scene_export.h"

namespace prt {
namespace {

using nlohmann::json;

std::span<const float> flat(const std::vector<Vec3f>& v) { return {v[0].data(), v.size() * 3}; }

std::uint32_t add_unit_vectors(const std::vector<Vec3f>& vectors, GltfWriter& writer) {
  std::vector<std::int16_t> integers;
  integers.reserve(vectors.size() * 3);
  for (const float v : flat(vectors)) {
    const float clamped = std::clamp(v, -1.0F, 1.0F);
    integers.push_back(static_cast<std::int16_t>(std::lround(clamped * kUnitScale)));
  }
  return writer.add(std::span<const std::int16_t>(integers), 3, GltfWriter::Use::kData, true);
}

json write_samples(const SampleSet& samples, const std::vector<std::uint32_t>& new_triangle,
                   GltfWriter& writer) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(samples.size());
  for (const std::uint32_t t : samples.triangles) triangles.push_back(new_triangle[t]);
  return {{"count", samples.size()},
          {"positions", writer.add(flat(samples.positions), 3)},
          {"normals", add_unit_vectors(samples.normals, writer)},
          {"tangents", add_unit_vectors(samples.tangents, writer)},
          {"areas", writer.add(std::span(samples.areas))},
          {"radii", writer.add(std::span(samples.radii))},
          {"triangles", writer.add(std::span<const std::uint32_t>(triangles))},
          {"cluster_begin", writer.add(std::span(samples.cluster_begin))}};
}

bool has_walls(const DepthVisibility& visibility) {
  return std::ranges::any_of(visibility.clusters,
                             [](const DepthBlock& block) { return block.walls.size() > 0; });
}

void add_walls(const DepthVisibility& visibility, json& entry, GltfWriter& writer) {
  std::vector<float> walls;
  entry["wall_counts"] = json::array();
  for (const DepthBlock& block : visibility.clusters) {
    walls.insert(walls.end(), block.walls.data(), block.walls.data() + block.walls.size());
    entry["wall_counts"].push_back(block.walls.rows());
  }
  entry["walls"] = writer.add(std::span<const float>(walls), 4);
}

json write_visibility(const DepthVisibility& visibility, GltfWriter& writer) {
  std::vector<const QuantisedMatrix*> means;
  std::vector<const QuantisedMatrix*> bases;
  std::vector<const QuantisedMatrix*> coefficients;
  for (const DepthBlock& block : visibility.clusters) {
    means.push_back(&block.mean);
    bases.push_back(&block.basis);
    coefficients.push_back(&block.coefficients);
  }
  json entry = {{"directions", visibility.directions},
                {"bound", visibility.bound},
                {"bias", visibility.bias},
                {"means", write_matrices(means, writer)},
                {"bases", write_matrices(bases, writer)},
                {"coefficients", write_matrices(coefficients, writer)}};
  if (has_walls(visibility)) add_walls(visibility, entry, writer);
  return entry;
}

json write_operator(const ClusterProjection& projection, GltfWriter& writer) {
  std::vector<const QuantisedMatrix*> blocks;
  for (const QuantisedMatrix& block : projection.blocks) blocks.push_back(&block);
  return {{"type", kClusterProjection}, {"blocks", write_matrices(blocks, writer)}};
}

json write_operator(const ClusterTransfer& transfer, GltfWriter& writer) {
  std::vector<const QuantisedMatrix*> left;
  std::vector<const QuantisedMatrix*> right;
  std::vector<std::uint32_t> senders;
  json counts = json::array();
  for (const ReceiverTransfer& receiver : transfer.receivers) {
    left.push_back(&receiver.left);
    right.push_back(&receiver.right);
    senders.insert(senders.end(), receiver.senders.begin(), receiver.senders.end());
    counts.push_back(receiver.senders.size());
  }
  json entry = {{"type", kClusterTransfer},
                {"channels", transfer.channels},
                {"sender_counts", std::move(counts)},
                {"left", write_matrices(left, writer)},
                {"right", write_matrices(right, writer)}};
  if (!senders.empty()) entry["senders"] = writer.add(std::span<const std::uint32_t>(senders));
  return entry;
}

/// Indices below `limit`, in 16 bits where they fit, as glTF does it with vertices.
std::uint32_t add_indices(const std::vector<std::uint32_t>& indices, std::size_t limit,
                          GltfWriter& writer) {
  if (limit > kShortIndices) return writer.add(std::span<const std::uint32_t>(indices));
  const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
  return writer.add(std::span<const std::uint16_t>(narrow));
}

json write_operator(const NearTransfer& near, GltfWriter& writer) {
  const auto add = [&](const std::vector<std::uint16_t>& values, unsigned components) {
    return writer.add(std::span<const std::uint16_t>(values), components, GltfWriter::Use::kData,
                      true);
  };
  json entry = {{"type", kNearTransfer},
                {"begin", writer.add(std::span<const std::uint32_t>(near.begin))},
                {"albedo", add(near.albedo, near.channels)}};
  if (!near.senders.empty()) {
    entry["senders"] = add_indices(near.senders, near.begin.size() - 1, writer);
    entry["shares"] = add(near.shares, 1);
  }
  entry["channels"] = near.channels;
  return entry;
}

json write_step(const DirectLightStep& step) {
  const bool depth = step.shadow == DirectLightStep::Shadow::kDepth;
  return {{"step", "direct_light"}, {"output", step.output}, {"shadow", depth ? "depth" : "none"}};
}
json write_step(const EnvironmentLightStep& step) {
  return {{"step", "environment_light"},
          {"operator", step.op},
          {"coefficients", step.coefficients},
          {"output", step.output}};
}
json write_step(const ApplyStep& step) {
  return {{"step", "apply"}, {"operator", step.op}, {"input", step.input}, {"output", step.output}};
}
json write_step(const AddStep& step) {
  return {{"step", "add"}, {"a", step.a}, {"b", step.b}, {"output", step.output}};
}
json write_step(const ReconstructStep& step) {
  return {{"step", "reconstruct"}, {"input", step.input}, {"kernel", "splats"}};
}

json write_spaces(const Package& package) {
  json spaces = json::array();
  for (const Space& space : package.spaces) {
    const char* kind = space.kind == Space::Kind::kSampleIrradiance      ? kSampleIrradiance
                       : space.kind == Space::Kind::kClusterCoefficients ? kClusterCoefficients
                                                                         : kEnvironmentCoefficients;
    spaces.push_back({{"name", space.name}, {"kind", kind}, {"dimension", space.dimension}});
  }
  return spaces;
}

json units() {
  return {{"length", "m"},
          {"irradiance", "W/m²"},
          {"area", "m²"},
          {"depth", "sqrt(distance / bound)"},
          {"directions", "equal-area grid over the hemisphere, concentric map, z = 1 - r²"}};
}

json write_extension(const Package& package, const std::vector<std::uint32_t>& new_triangle,
                     GltfWriter& writer) {
  const bool walls = package.visibility && has_walls(*package.visibility);
  const std::uint64_t version = environment_order(package) > 0 ? kFormatVersion
                                : walls                        ? kVersionWithoutEnvironment
                                                               : kVersionWithoutWalls;
  json extension = {{"version", version},
                    {"units", units()},
                    {"triangles", package.scene.triangles.size()},
                    {"samples", write_samples(package.samples, new_triangle, writer)},
                    {"spaces", write_spaces(package)},
                    {"operators", json::object()},
                    {"program", json::array()},
                    {"provenance", package.provenance},
                    {"error", package.error}};
  if (package.scene.recentred()) {
    const Vec3d& o = package.scene.origin;
    extension[kOrigin] = {o.x(), o.y(), o.z()};
  }
  if (package.visibility) extension["visibility"] = write_visibility(*package.visibility, writer);
  for (const auto& [name, op] : package.operators) {
    extension["operators"][name] =
        std::visit([&](const auto& o) { return write_operator(o, writer); }, op);
  }
  for (const ProgramStep& step : package.program) {
    extension["program"].push_back(std::visit([](const auto& s) { return write_step(s); }, step));
  }
  return extension;
}

}  // namespace

std::vector<std::byte> encode_package(const Package& package) {
  validate(package, "the package to write");
  GltfWriter writer;
  writer.root["asset"] = {{"version", "2.0"}, {"generator", "prtbake"}};
  const std::vector<std::uint32_t> new_triangle = export_scene(package.scene, writer);
  writer.root["extensionsUsed"].push_back(kExtension);
  writer.root["extensions"][kExtension] = write_extension(package, new_triangle, writer);
  return writer.finish();
}

void write_package(const Package& package, const std::filesystem::path& file) {
  write_file_atomically(file, encode_package(package));
}

}  // namespace prt
