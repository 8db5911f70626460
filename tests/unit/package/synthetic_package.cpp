#include "unit/package/synthetic_package.h"

#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/image_file.h"
#include "bases/depth_basis.h"
#include "bases/spherical_harmonics.h"

namespace prt::test {
namespace {

struct Wall {
  Vec3f corner, edge_u, edge_v, normal;
};

/// Walls seen from inside; edge_u × edge_v points inwards.
std::vector<Wall> walls(const Vec3f& s) {
  const Vec3f x(s.x(), 0, 0);
  const Vec3f y(0, s.y(), 0);
  const Vec3f z(0, 0, s.z());
  const Vec3f o = Vec3f::Zero();
  return {{o, z, x, Vec3f::UnitY()},  {y, x, z, -Vec3f::UnitY()}, {o, y, z, Vec3f::UnitX()},
          {x, z, y, -Vec3f::UnitX()}, {o, x, y, Vec3f::UnitZ()},  {z, y, x, -Vec3f::UnitZ()}};
}

float distance_to_walls(const Vec3f& p, const Vec3f& d, const Vec3f& size) {
  float t = kInfinity;
  for (int k = 0; k < 3; ++k) {
    if (d[k] > 0.0F) t = std::min(t, (size[k] - p[k]) / d[k]);
    if (d[k] < 0.0F) t = std::min(t, -p[k] / d[k]);
  }
  return t;
}

SampleSet wall_samples(const SyntheticRoom& room) {
  SampleSet samples;
  samples.cluster_begin.push_back(0);
  const int n = room.samples_per_edge;
  std::uint32_t triangle = 0;
  for (const Wall& wall : walls(room.size)) {
    const float du = wall.edge_u.norm() / static_cast<float>(n);
    const float dv = wall.edge_v.norm() / static_cast<float>(n);
    for (int k = 0; k < n * n; ++k) {
      const float u = (static_cast<float>(k % n) + 0.5F) / static_cast<float>(n);
      const float v = (static_cast<float>(k / n) + 0.5F) / static_cast<float>(n);
      samples.positions.emplace_back(wall.corner + u * wall.edge_u + v * wall.edge_v);
      samples.normals.push_back(wall.normal);
      samples.tangents.emplace_back(wall.edge_u.normalized());
      samples.areas.push_back(du * dv);
      samples.radii.push_back(std::max(du, dv));
      samples.triangles.push_back(triangle + (u > v ? 0U : 1U));
    }
    triangle += 2;
    samples.cluster_begin.push_back(static_cast<std::uint32_t>(samples.size()));
  }
  return samples;
}

QuantisedMatrix packed(const MatrixF& m, int bits) { return quantise(m, bits).matrix; }

DepthVisibility exact_depths(const SampleSet& samples, const SyntheticRoom& room) {
  const HemisphereDirections directions(room.directions);
  const int d = directions.count();
  DepthVisibility visibility;
  visibility.directions = d;
  visibility.bound = room.size.norm();
  for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
    MatrixF depths(samples.cluster_size(c), d);
    for (std::uint32_t i = 0; i < samples.cluster_size(c); ++i) {
      const std::uint32_t s = samples.cluster_begin[c] + i;
      for (int j = 0; j < d; ++j) {
        const Vec3f ray = samples.frame(s) * directions.direction(j);
        depths(i, j) =
            encode_depth(distance_to_walls(samples.positions[s], ray, room.size), visibility.bound);
      }
    }
    visibility.clusters.push_back({packed(MatrixF::Zero(1, d), room.bits),
                                   packed(MatrixF::Identity(d, d), room.bits),
                                   packed(depths, room.bits)});
  }
  return visibility;
}

void add_transfer(Package& package, const SyntheticRoom& room) {
  const SampleSet& samples = package.samples;
  const auto clusters = static_cast<std::uint32_t>(samples.clusters());
  ClusterProjection projection;
  ClusterTransfer transfer;
  transfer.channels = room.channels;
  double area = 0.0;
  for (const float a : samples.areas) area += a;
  MatrixF right(1, room.channels * clusters);
  for (std::uint32_t channel = 0; channel < room.channels; ++channel) {
    const float gain = room.albedo[channel] / (1.0F - room.albedo[channel]);
    right.middleCols(channel * clusters, clusters).setConstant(gain / static_cast<float>(area));
  }
  for (std::uint32_t c = 0; c < clusters; ++c) {
    MatrixF block(1, samples.cluster_size(c));
    for (std::uint32_t i = 0; i < samples.cluster_size(c); ++i) {
      block(0, i) = samples.areas[samples.cluster_begin[c] + i];
    }
    projection.blocks.push_back(packed(block, room.bits));
    ReceiverTransfer receiver;
    for (std::uint32_t s = 0; s < clusters; ++s) receiver.senders.push_back(s);
    receiver.left = packed(MatrixF::Ones(samples.cluster_size(c), 1), room.bits);
    receiver.right = packed(right, room.bits);
    transfer.receivers.push_back(std::move(receiver));
  }
  package.operators.emplace("project", std::move(projection));
  package.operators.emplace("transfer", std::move(transfer));
  const auto n = static_cast<std::uint32_t>(samples.size());
  package.spaces = {{"e", Space::Kind::kSampleIrradiance, n},
                    {"c", Space::Kind::kClusterCoefficients, clusters},
                    {"i", Space::Kind::kSampleIrradiance, n},
                    {"sum", Space::Kind::kSampleIrradiance, n}};
  const auto shadow =
      package.visibility ? DirectLightStep::Shadow::kDepth : DirectLightStep::Shadow::kNone;
  package.program = {DirectLightStep{"e", shadow}, ApplyStep{"project", "e", "c"},
                     ApplyStep{"transfer", "c", "i"}, AddStep{"e", "i", "sum"},
                     ReconstructStep{"sum"}};
}

}  // namespace

void add_quad(Scene& scene, const Vec3f& corner, const Vec3f& u, const Vec3f& v,
              std::uint32_t material, std::uint32_t surface) {
  const auto first = static_cast<std::uint32_t>(scene.positions.size());
  const Vec3f normal = u.cross(v).normalized();
  for (int k = 0; k < 4; ++k) {
    const auto a = static_cast<float>(k == 1 || k == 2);
    const auto b = static_cast<float>(k >= 2);
    scene.positions.emplace_back(corner + a * u + b * v);
    scene.normals.push_back(normal);
    scene.uvs.emplace_back(a, b);
  }
  scene.triangles.push_back({{first, first + 1, first + 2}, material, surface});
  scene.triangles.push_back({{first, first + 2, first + 3}, material, surface});
}

std::vector<std::byte> tiny_png() {
  const auto path =
      std::filesystem::temp_directory_path() / ("prt_tiny_" + std::to_string(getpid()) + ".png");
  const std::vector<std::uint8_t> pixels = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  write_png(path, 2, 2, pixels);
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  std::filesystem::remove(path);
  const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
  return {data, data + bytes.size()};
}

Scene rich_scene(const Vec3f& size) {
  Scene scene;
  std::uint32_t surface = 0;
  for (const Wall& wall : walls(size)) {
    add_quad(scene, wall.corner, wall.edge_u, wall.edge_v, surface % 2 == 0 ? 1 : 0, surface);
    ++surface;
  }
  add_quad(scene, 0.4F * size, Vec3f(0.5F, 0, 0), Vec3f(0, 0.5F, 0), 2, surface);
  Material red{.name = "red", .base_color = Vec3f(0.8F, 0.1F, 0.1F)};
  red.double_sided = true;
  Material leaf{.name = "leaf", .texture = 0, .alpha_mask = true, .alpha_cutoff = 0.25F};
  scene.materials = {red, {.name = "grey", .base_color = Vec3f(0.5F, 0.5F, 0.5F)}, leaf};
  Texture texture;
  texture.width = 2;
  texture.height = 2;
  texture.rgba = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};
  texture.wrap_u = Texture::Wrap::kClamp;
  texture.encoded = tiny_png();
  texture.mime_type = "image/png";
  scene.textures = {texture};
  scene.camera = SceneCamera{.eye = Vec3f(0.5F, 1.6F, 0.5F), .target = size, .vertical_fov = 0.8F};
  SceneLight bulb;
  bulb.name = "bulb";
  bulb.position = 0.5F * size;
  bulb.intensity = Vec3f(5, 4, 3);
  SceneLight spot;
  spot.kind = SceneLight::Kind::kSpot;
  spot.position = 0.6F * size;
  spot.direction = Vec3f(0.6F, -0.8F, 0);
  spot.intensity = Vec3f(1, 2, 3);
  spot.inner_angle = 0.2F;
  spot.outer_angle = 0.5F;
  SceneLight sun;
  sun.kind = SceneLight::Kind::kSun;
  sun.direction = -Vec3f::UnitY();
  sun.intensity = Vec3f(900, 800, 700);
  scene.lights = {bulb, spot, sun};
  scene.bounds_max = size;
  return scene;
}

void see_up_to_walls(Package& package, const Vec3f& size) {
  for (std::size_t c = 0; c < package.samples.clusters(); ++c) {
    const Vec3f& own = package.samples.normals[package.samples.cluster_begin[c]];
    MatrixF walls = MatrixF::Zero(5, 4);
    Eigen::Index w = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (const float side : {-1.0F, 1.0F}) {
        if (own[axis] * side < 0.0F) continue;  // its own
        walls(w, axis) = side;
        walls(w++, 3) = side > 0.0F ? size[axis] : 0.0F;
      }
    }
    package.visibility->clusters[c] = {{}, {}, {}, walls};
  }
}

void add_near(Package& package, std::uint32_t channels) {
  const auto n = static_cast<std::uint32_t>(package.samples.size());
  NearTransfer near;
  near.channels = channels;
  near.begin = {0};
  for (std::uint32_t r = 0; r < n; ++r) {
    near.senders.insert(near.senders.end(), {(r + 7) % n, (r + 50) % n});
    near.shares.insert(near.shares.end(), {pack_share(0.25F), pack_share(0.5F)});
    near.begin.push_back(static_cast<std::uint32_t>(near.senders.size()));
    for (const float a : channels == 3 ? std::vector{0.2F, 0.4F, 0.8F} : std::vector{0.4F}) {
      near.albedo.push_back(pack_share(a));
    }
  }
  package.operators["near"] = std::move(near);
  package.spaces.push_back({"n", Space::Kind::kSampleIrradiance, n});
  package.spaces.push_back({"n+i", Space::Kind::kSampleIrradiance, n});
  package.program.pop_back();
  package.program.pop_back();
  package.program.insert(package.program.end(),
                         {ApplyStep{"near", "e", "n"}, AddStep{"n", "i", "n+i"},
                          AddStep{"e", "n+i", "sum"}, ReconstructStep{"sum"}});
}

void add_environment(Package& package, int order, std::uint32_t channels, bool reflected) {
  const SampleSet& samples = package.samples;
  const auto n = static_cast<std::uint32_t>(samples.size());
  const Eigen::Index functions = sh_count(order);
  const std::array<float, 3> share =
      channels == 3 ? std::array{0.1F, 0.2F, 0.5F} : std::array{0.2F, 0.2F, 0.2F};
  ClusterTransfer sky, bounced;
  sky.channels = 1;
  bounced.channels = channels;
  for (std::uint32_t c = 0; c < samples.clusters(); ++c) {
    MatrixF direct(samples.cluster_size(c), functions);
    for (std::uint32_t i = 0; i < samples.cluster_size(c); ++i) {
      const Vec3d normal = samples.normals[samples.cluster_begin[c] + i].cast<double>();
      direct.row(i) = lambert_sh(order, normal).transpose().cast<float>();
    }
    MatrixF right(1, static_cast<Eigen::Index>(channels) * functions);
    for (std::uint32_t h = 0; h < channels; ++h) {
      right.middleCols(h * functions, functions) = share[h] * direct.colwise().mean();
    }
    sky.receivers.push_back(
        {{0}, packed(direct, 32), packed(MatrixF::Identity(functions, functions), 32)});
    bounced.receivers.push_back(
        {{0}, packed(MatrixF::Ones(direct.rows(), 1), 16), packed(right, 16)});
  }
  package.operators["sky"] = std::move(sky);
  package.operators["bounced"] = std::move(bounced);
  package.spaces.push_back(
      {"sky light", Space::Kind::kEnvironmentCoefficients, static_cast<std::uint32_t>(functions)});
  for (const char* name : {"sky", "e+sky", "bounced", "all", "everything"}) {
    package.spaces.push_back({name, Space::Kind::kSampleIrradiance, n});
  }
  package.program.pop_back();
  std::vector<ProgramStep> more = {
      EnvironmentLightStep{"sky", "sky light", "sky"}, ApplyStep{"bounced", "sky light", "bounced"},
      AddStep{"sum", "bounced", "all"}, AddStep{"sky", "all", "everything"},
      ReconstructStep{"everything"}};
  package.program.insert(package.program.end(), more.begin(), more.end());
  if (!reflected) return;
  // The room's projection reads the sky's light with the lights'.
  package.program.insert(package.program.begin() + 1, {more[0], AddStep{"e", "sky", "e+sky"}});
  const auto again =
      std::find_if(package.program.begin() + 3, package.program.end(),
                   [](const auto& s) { return std::holds_alternative<EnvironmentLightStep>(s); });
  package.program.erase(again);
  for (ProgramStep& step : package.program) {
    auto* apply = std::get_if<ApplyStep>(&step);
    if (apply != nullptr && apply->input == "e") apply->input = "e+sky";
  }
}

Package synthetic_room(const SyntheticRoom& room) {
  Package package;
  package.scene = rich_scene(room.size);
  package.samples = wall_samples(room);
  if (room.directions > 0) package.visibility = exact_depths(package.samples, room);
  add_transfer(package, room);
  package.provenance = {{"method", "synthetic"}};
  package.error = {{"indirect", {{"rel_rmse", 0.0}}}};
  return package;
}

}  // namespace prt::test
