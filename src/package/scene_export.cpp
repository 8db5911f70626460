#include "package/scene_export.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace prt {
namespace {

using nlohmann::json;

/// glTF's photometric units: candela and lux are watts times this (683 lm/W).
constexpr double kLumensPerWatt = 683.0;

constexpr int kClampToEdge = 33071;
constexpr int kMirroredRepeat = 33648;
constexpr int kRepeat = 10497;

/// The largest vertex count whose indices fit 16 bits: 65535 itself restarts a strip.
constexpr std::size_t kShortIndexVertices = 65535;

template <typename Vector>
json numbers(const Vector& v) {
  return {v.x(), v.y(), v.z()};
}

int wrap_mode(Texture::Wrap wrap) {
  switch (wrap) {
    case Texture::Wrap::kClamp:
      return kClampToEdge;
    case Texture::Wrap::kMirror:
      return kMirroredRepeat;
    case Texture::Wrap::kRepeat:
      break;
  }
  return kRepeat;
}

/// Images with equal bytes and samplers with equal modes are written once.
void export_textures(const Scene& scene, GltfWriter& writer) {
  if (scene.textures.empty()) return;
  json& root = writer.root;
  std::vector<std::size_t> image_of;
  std::vector<std::size_t> image_source;
  root["samplers"] = json::array();
  for (std::size_t t = 0; t < scene.textures.size(); ++t) {
    const Texture& texture = scene.textures[t];
    if (texture.encoded.empty()) throw std::logic_error("a texture without its file's bytes");
    const auto same = std::find_if(image_source.begin(), image_source.end(), [&](std::size_t s) {
      return scene.textures[s].encoded == texture.encoded;
    });
    const auto image = static_cast<std::size_t>(same - image_source.begin());
    if (same == image_source.end()) {
      image_source.push_back(t);
      root["images"].push_back(
          {{"bufferView", writer.add_view(texture.encoded)}, {"mimeType", texture.mime_type}});
    }
    const json sampler = {{"wrapS", wrap_mode(texture.wrap_u)},
                          {"wrapT", wrap_mode(texture.wrap_v)}};
    json& samplers = root["samplers"];
    const auto known = std::find(samplers.begin(), samplers.end(), sampler);
    const auto place = static_cast<std::size_t>(known - samplers.begin());
    if (known == samplers.end()) samplers.push_back(sampler);
    root["textures"].push_back({{"source", image}, {"sampler", place}});
  }
}

void export_materials(const Scene& scene, GltfWriter& writer) {
  for (const Material& material : scene.materials) {
    json surface = {{"baseColorFactor",
                     {material.base_color.x(), material.base_color.y(), material.base_color.z(),
                      material.base_alpha}},
                    {"metallicFactor", 0.0},
                    {"roughnessFactor", 1.0}};
    if (material.texture != kNone) surface["baseColorTexture"] = {{"index", material.texture}};
    json entry = {{"pbrMetallicRoughness", std::move(surface)}};
    if (!material.name.empty()) entry["name"] = material.name;
    if (material.alpha_mask) {
      entry["alphaMode"] = "MASK";
      entry["alphaCutoff"] = material.alpha_cutoff;
    }
    if (material.double_sided) entry["doubleSided"] = true;
    writer.root["materials"].push_back(std::move(entry));
  }
}

/// Vertices of one primitive, numbered by first use.
struct Primitive {
  std::vector<std::uint32_t> vertices;  ///< of the scene
  std::vector<std::uint32_t> indices;
};

Primitive collect(const Scene& scene, std::span<const std::uint32_t> triangles,
                  std::vector<std::uint32_t>& place) {
  Primitive primitive;
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t v : scene.triangles[t].vertex) {
      if (place[v] == kNone) {
        place[v] = static_cast<std::uint32_t>(primitive.vertices.size());
        primitive.vertices.push_back(v);
      }
      primitive.indices.push_back(place[v]);
    }
  }
  for (const std::uint32_t v : primitive.vertices) place[v] = kNone;
  return primitive;
}

template <typename Vector>
std::vector<float> gather(const std::vector<Vector>& values, const Primitive& primitive) {
  std::vector<float> flat;
  flat.reserve(primitive.vertices.size() * Vector::RowsAtCompileTime);
  for (const std::uint32_t v : primitive.vertices) {
    flat.insert(flat.end(), values[v].data(), values[v].data() + Vector::RowsAtCompileTime);
  }
  return flat;
}

json export_primitive(const Scene& scene, std::uint32_t material, const Primitive& primitive,
                      GltfWriter& writer) {
  using Use = GltfWriter::Use;
  const std::vector<float> normals = gather(scene.normals, primitive);
  json attributes = {{"POSITION", writer.add_positions(gather(scene.positions, primitive))},
                     {"NORMAL", writer.add(std::span(normals), 3, Use::kVertices)}};
  if (scene.materials[material].texture != kNone) {
    const std::vector<float> uvs = gather(scene.uvs, primitive);
    attributes["TEXCOORD_0"] = writer.add(std::span(uvs), 2, Use::kVertices);
  }
  std::uint32_t indices = 0;
  if (primitive.vertices.size() <= kShortIndexVertices) {
    const std::vector<std::uint16_t> narrow(primitive.indices.begin(), primitive.indices.end());
    indices = writer.add(std::span(narrow), 1, Use::kIndices);
  } else {
    indices = writer.add(std::span(primitive.indices), 1, Use::kIndices);
  }
  return {{"attributes", std::move(attributes)}, {"indices", indices}, {"material", material}};
}

/// Rotation as glTF's x, y, z, w.
json quaternion(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

void export_camera(const SceneCamera& camera, float diagonal, GltfWriter& writer) {
  const Vec3d back = (camera.eye - camera.target).cast<double>().normalized();
  Vec3d right = camera.up.cast<double>().cross(back);
  if (right.norm() < 1e-6) right = back.unitOrthogonal();  // looking straight up or down
  right.normalize();
  Eigen::Matrix3d axes;
  axes.col(0) = right;
  axes.col(1) = back.cross(right);
  axes.col(2) = back;
  writer.root["cameras"].push_back(
      {{"type", "perspective"},
       {"perspective",
        {{"yfov", camera.vertical_fov}, {"znear", 1e-3 * std::max(diagonal, 1e-3F)}}}});
  writer.root["nodes"].push_back({{"camera", 0},
                                  {"translation", numbers(camera.eye)},
                                  {"rotation", quaternion(Eigen::Quaterniond(axes).normalized())}});
}

/// glTF's lights shine along their node's -z axis.
void export_light(const SceneLight& light, GltfWriter& writer) {
  const float strength = light.intensity.maxCoeff();
  const Vec3f color = strength > 0.0F ? Vec3f(light.intensity / strength) : Vec3f::Ones();
  const bool is_sun = light.kind == SceneLight::Kind::kSun;
  const bool is_spot = light.kind == SceneLight::Kind::kSpot;
  json entry = {{"type", is_sun    ? "directional"
                         : is_spot ? "spot"
                                   : "point"},
                {"color", numbers(color)},
                {"intensity", kLumensPerWatt * std::max(0.0F, strength)}};
  if (!light.name.empty()) entry["name"] = light.name;
  if (is_spot) {
    const double outer = std::clamp<double>(light.outer_angle, 1e-4, EIGEN_PI / 2.0);
    entry["spot"] = {
        {"outerConeAngle", outer},
        {"innerConeAngle", std::clamp<double>(light.inner_angle, 0.0, outer * 0.9999)}};
  }
  json& lights = writer.root["extensions"]["KHR_lights_punctual"]["lights"];
  lights.push_back(std::move(entry));
  const auto rotation =
      Eigen::Quaterniond::FromTwoVectors(Vec3d(-Vec3d::UnitZ()), light.direction.cast<double>());
  writer.root["nodes"].push_back(
      {{"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}},
       {"translation", numbers(light.position)},
       {"rotation", quaternion(rotation.normalized())}});
}

}  // namespace

std::vector<std::uint32_t> export_scene(const Scene& scene, GltfWriter& writer) {
  json& root = writer.root;
  const std::vector<std::uint32_t> order = triangles_by_material(scene);
  std::vector<std::uint32_t> place(scene.positions.size(), kNone);
  json primitives = json::array();
  for (std::size_t begin = 0; begin < order.size();) {
    const std::uint32_t material = scene.triangles[order[begin]].material;
    std::size_t end = begin;
    while (end < order.size() && scene.triangles[order[end]].material == material) ++end;
    const std::span triangles(order.data() + begin, end - begin);
    primitives.push_back(
        export_primitive(scene, material, collect(scene, triangles, place), writer));
    begin = end;
  }
  root["meshes"].push_back({{"primitives", std::move(primitives)}});
  root["nodes"].push_back({{"mesh", 0}});
  export_materials(scene, writer);
  export_textures(scene, writer);
  if (scene.camera) export_camera(*scene.camera, scene.diagonal(), writer);
  for (const SceneLight& light : scene.lights) export_light(light, writer);
  if (!scene.lights.empty()) root["extensionsUsed"].push_back("KHR_lights_punctual");
  json nodes = json::array();
  for (std::size_t n = 0; n < root["nodes"].size(); ++n) nodes.push_back(n);
  if (scene.recentred()) {
    root["nodes"].push_back({{"translation", numbers(scene.origin)}, {"children", nodes}});
    nodes = json::array({root["nodes"].size() - 1});
  }
  root["scenes"].push_back({{"nodes", std::move(nodes)}});
  root["scene"] = 0;

  std::vector<std::uint32_t> place_of(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) place_of[order[i]] = i;
  return place_of;
}

}  // namespace prt
