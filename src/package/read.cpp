#include "package/read.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "base/error.h"
#include "package/extension.h"
#include "package/matrix_list.h"
#include "scene/load.h"

namespace prt {
namespace {

using gltf::Document;
using gltf::Value;

std::vector<Vec3f> read_points(const Document& document, const Value& accessor) {
  const std::vector<float> xyz = read_array<float>(document, accessor, 3);
  std::vector<Vec3f> points;
  points.reserve(xyz.size() / 3);
  for (std::size_t i = 0; i < xyz.size(); i += 3)
    points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
  return points;
}

std::vector<Vec3f> read_unit_vectors(const Document& document, const Value& accessor) {
  const std::vector<std::int16_t> xyz = read_array<std::int16_t>(document, accessor, 3);
  std::vector<Vec3f> vectors;
  vectors.reserve(xyz.size() / 3);
  for (std::size_t i = 0; i < xyz.size(); i += 3) {
    const Vec3f v = Vec3f(xyz[i], xyz[i + 1], xyz[i + 2]) / kUnitScale;
    // Rounding is undone; a vector far from unit is left for validate() to find.
    vectors.push_back(std::abs(v.norm() - 1.0F) < 1e-3F ? Vec3f(v.normalized()) : v);
  }
  return vectors;
}

/// Rounded tangents are made orthogonal to their normals again.
void straighten_tangents(SampleSet& samples) {
  const std::size_t count = std::min(samples.normals.size(), samples.tangents.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f& n = samples.normals[i];
    Vec3f& t = samples.tangents[i];
    const float slope = n.dot(t);
    if (std::abs(slope) < 1e-3F) t = (t - slope * n).normalized();
  }
}

SampleSet read_samples(const Document& document, const Value& json) {
  SampleSet samples;
  samples.positions = read_points(document, json["positions"]);
  samples.normals = read_unit_vectors(document, json["normals"]);
  samples.tangents = read_unit_vectors(document, json["tangents"]);
  samples.areas = read_array<float>(document, json["areas"]);
  samples.radii = read_array<float>(document, json["radii"]);
  samples.triangles = read_array<std::uint32_t>(document, json["triangles"]);
  samples.cluster_begin = read_array<std::uint32_t>(document, json["cluster_begin"]);
  if (json["count"].whole() != samples.size())
    json["count"].fail("there are not that many positions");
  straighten_tangents(samples);
  return samples;
}

/// Inverse of the writer's add_walls().
void read_walls(const Document& document, const Value& json, std::vector<DepthBlock>& blocks) {
  const std::vector<Value> counts = json.list("wall_counts");
  if (counts.size() != blocks.size()) json["wall_counts"].fail("should have an entry per cluster");
  const std::vector<float> walls = read_array<float>(document, json["walls"], 4);
  std::size_t used = 0;
  for (std::size_t c = 0; c < blocks.size(); ++c) {
    const std::uint64_t count = counts[c].whole();
    if (count > walls.size() / 4 - used) counts[c].fail("there are not that many walls");
    blocks[c].walls =
        Eigen::Map<const MatrixF>(walls.data() + 4 * used, static_cast<Eigen::Index>(count), 4);
    used += count;
  }
  if (4 * used != walls.size()) json["wall_counts"].fail("there are more walls than that");
}

DepthVisibility read_visibility(const Document& document, const Value& json) {
  DepthVisibility visibility;
  visibility.directions =
      static_cast<int>(json["directions"].index(kMaxDirections + 1, "directions"));
  visibility.bound = static_cast<float>(json["bound"].number());
  visibility.bias = static_cast<float>(json["bias"].number());
  std::vector<QuantisedMatrix> means = read_matrices(document, json["means"]);
  std::vector<QuantisedMatrix> bases = read_matrices(document, json["bases"]);
  std::vector<QuantisedMatrix> coefficients = read_matrices(document, json["coefficients"]);
  if (bases.size() != means.size() || coefficients.size() != means.size()) {
    json.fail("its lists of matrices differ in length");
  }
  for (std::size_t c = 0; c < means.size(); ++c) {
    visibility.clusters.push_back(
        {std::move(means[c]), std::move(bases[c]), std::move(coefficients[c]), {}});
  }
  if (json.find("walls")) read_walls(document, json, visibility.clusters);
  return visibility;
}

ClusterTransfer read_transfer(const Document& document, const Value& json) {
  ClusterTransfer transfer;
  transfer.channels = json["channels"].index(4, "channels");
  std::vector<QuantisedMatrix> left = read_matrices(document, json["left"]);
  std::vector<QuantisedMatrix> right = read_matrices(document, json["right"]);
  const std::vector<Value> counts = json.list("sender_counts");
  if (right.size() != left.size() || counts.size() != left.size()) {
    json.fail("its lists differ in length");
  }
  std::vector<std::uint32_t> senders;
  if (const auto accessor = json.find("senders")) {
    senders = read_array<std::uint32_t>(document, *accessor);
  }
  std::size_t used = 0;
  for (std::size_t r = 0; r < left.size(); ++r) {
    const std::uint64_t count = counts[r].whole();
    if (count > senders.size() - used) counts[r].fail("there are not that many senders");
    const auto begin = senders.begin() + static_cast<std::ptrdiff_t>(used);
    transfer.receivers.push_back({{begin, begin + static_cast<std::ptrdiff_t>(count)},
                                  std::move(left[r]),
                                  std::move(right[r])});
    used += count;
  }
  if (used != senders.size()) json["sender_counts"].fail("there are more senders than that");
  return transfer;
}

/// Inverse of the writer's add_indices().
std::vector<std::uint32_t> read_indices(const Document& document, const Value& accessor,
                                        std::size_t limit) {
  if (limit > kShortIndices) return read_array<std::uint32_t>(document, accessor);
  const std::vector<std::uint16_t> narrow = read_array<std::uint16_t>(document, accessor);
  return {narrow.begin(), narrow.end()};
}

NearTransfer read_near(const Document& document, const Value& json) {
  NearTransfer near;
  near.channels = json["channels"].index(4, "channels");
  if (near.channels != 1 && near.channels != 3) json["channels"].fail("must be 1 or 3");
  near.begin = read_array<std::uint32_t>(document, json["begin"]);
  near.albedo = read_array<std::uint16_t>(document, json["albedo"], near.channels);
  if (const auto senders = json.find("senders")) {
    near.senders = read_indices(document, *senders, near.begin.size() - 1);
    near.shares = read_array<std::uint16_t>(document, json["shares"]);
  }
  return near;
}

PackageOperator read_operator(const Document& document, const Value& json) {
  const std::string type = json["type"].text();
  if (type == kClusterProjection) {
    return ClusterProjection{read_matrices(document, json["blocks"])};
  }
  if (type == kClusterTransfer) return read_transfer(document, json);
  if (type == kNearTransfer) return read_near(document, json);
  json["type"].fail(fmt::format("'{}' is not a known operator; use a newer prt_play", type));
}

std::vector<Space> read_spaces(const Value& extension) {
  static const std::map<std::string, Space::Kind> kinds = {
      {kSampleIrradiance, Space::Kind::kSampleIrradiance},
      {kClusterCoefficients, Space::Kind::kClusterCoefficients},
      {kEnvironmentCoefficients, Space::Kind::kEnvironmentCoefficients}};
  std::vector<Space> spaces;
  for (const Value& json : extension.list("spaces")) {
    const std::string kind = json["kind"].text();
    const auto known = kinds.find(kind);
    if (known == kinds.end()) {
      json["kind"].fail(fmt::format("'{}' is not a known kind of space", kind));
    }
    spaces.push_back(
        {json["name"].text(), known->second, json["dimension"].index(kNone, "dimensions")});
  }
  return spaces;
}

ProgramStep read_step(const Value& json) {
  const std::string step = json["step"].text();
  if (step == "direct_light") {
    const std::string shadow = json["shadow"].text();
    if (shadow != "depth" && shadow != "none") json["shadow"].fail("should be 'depth' or 'none'");
    return DirectLightStep{json["output"].text(), shadow == "depth"
                                                      ? DirectLightStep::Shadow::kDepth
                                                      : DirectLightStep::Shadow::kNone};
  }
  if (step == "environment_light") {
    return EnvironmentLightStep{json["operator"].text(), json["coefficients"].text(),
                                json["output"].text()};
  }
  if (step == "apply") {
    return ApplyStep{json["operator"].text(), json["input"].text(), json["output"].text()};
  }
  if (step == "add") return AddStep{json["a"].text(), json["b"].text(), json["output"].text()};
  if (step == "reconstruct") {
    if (json["kernel"].text() != "splats") json["kernel"].fail("should be 'splats'");
    return ReconstructStep{json["input"].text()};
  }
  json["step"].fail(fmt::format("'{}' is not a known step; use a newer prt_play", step));
}

Value find_extension(const Document& document) {
  const auto extensions = document.root().find("extensions");
  const auto extension = extensions ? extensions->find(kExtension) : std::nullopt;
  if (!extension) {
    throw UserError(
        fmt::format("{}: it is glTF, but no package: it has no {}; give the .prt.glb "
                    "that prt_bake wrote",
                    document.name(), kExtension));
  }
  const std::uint64_t version = (*extension)["version"].whole();
  if (version < kVersionWithoutWalls || version > kFormatVersion) {
    throw UserError(
        fmt::format("{}: its {} has version {}, this program reads versions {} to {}; {}",
                    document.name(), kExtension, version, kVersionWithoutWalls, kFormatVersion,
                    version > kFormatVersion ? "use a newer program" : "bake it again"));
  }
  return *extension;
}

/// Where the positions of samples, and so of the scene, are counted from.
Vec3d read_origin(const Value& extension) {
  const auto json = extension.find(kOrigin);
  if (!json) return Vec3d::Zero();
  const std::vector<double> xyz = json->numbers(3);
  const Vec3d origin(xyz[0], xyz[1], xyz[2]);
  if (origin.cwiseAbs().maxCoeff() > kFarthestCoordinate) {
    json->fail(fmt::format("it lies beyond {} m", kFarthestCoordinate));
  }
  return origin;
}

}  // namespace

Package read_package(const std::filesystem::path& file) {
  Package package;
  const Document document(file);
  const Value extension = find_extension(document);
  package.scene = load_scene_about(file, read_origin(extension));
  if (extension["triangles"].whole() != package.scene.triangles.size()) {
    extension["triangles"].fail(fmt::format("{} triangles were read; the geometry was changed",
                                            package.scene.triangles.size()));
  }
  package.samples = read_samples(document, extension["samples"]);
  if (const auto visibility = extension.find("visibility")) {
    package.visibility = read_visibility(document, *visibility);
  }
  package.spaces = read_spaces(extension);
  const Value operators = extension["operators"];
  for (const std::string& name : operators.keys()) {
    package.operators.emplace(name, read_operator(document, operators[name.c_str()]));
  }
  for (const Value& step : extension.list("program")) package.program.push_back(read_step(step));
  package.provenance = extension["provenance"].json();
  package.error = extension["error"].json();
  validate(package, file.string());
  return package;
}

}  // namespace prt
