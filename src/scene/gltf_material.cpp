#include "scene/gltf_material.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace prt::gltf {
namespace {

Texture::Wrap wrap_mode(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Texture::Wrap::kClamp;
  if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Texture::Wrap::kMirror;
  return Texture::Wrap::kRepeat;
}

/// Loads each image once for each pair of wrap modes it is used with.
class TextureLoader {
 public:
  TextureLoader(const Document& document, Scene& scene) : document_(document), scene_(scene) {}

  /// Index into Scene::textures; kNone if the texture has no image that glTF itself knows.
  std::uint32_t load(int texture_index) {
    const tinygltf::Model& model = document_.model();
    const tinygltf::Texture& from = model.textures[static_cast<std::size_t>(texture_index)];
    if (from.source < 0) return kNone;
    Texture texture;
    if (from.sampler >= 0) {
      const tinygltf::Sampler& sampler = model.samplers[static_cast<std::size_t>(from.sampler)];
      texture.wrap_u = wrap_mode(sampler.wrapS);
      texture.wrap_v = wrap_mode(sampler.wrapT);
    }
    const auto key = std::tuple(from.source, texture.wrap_u, texture.wrap_v);
    if (const auto known = loaded_.find(key); known != loaded_.end()) return known->second;
    const auto image = static_cast<std::size_t>(from.source);
    decode_image(model.images[image].image, document_.root().element("images", image), texture);
    scene_.textures.push_back(std::move(texture));
    const auto index = static_cast<std::uint32_t>(scene_.textures.size() - 1);
    loaded_.emplace(key, index);
    return index;
  }

 private:
  const Document& document_;
  Scene& scene_;
  std::map<std::tuple<int, Texture::Wrap, Texture::Wrap>, std::uint32_t> loaded_;
};

TextureCoordinates texture_coordinates(const tinygltf::TextureInfo& info) {
  TextureCoordinates coordinates;
  coordinates.set = static_cast<std::uint32_t>(info.texCoord);
  const auto found = info.extensions.find("KHR_texture_transform");
  if (found == info.extensions.end()) return coordinates;
  const tinygltf::Value& transform = found->second;
  if (transform.Has("texCoord")) {
    coordinates.set = static_cast<std::uint32_t>(transform.Get("texCoord").GetNumberAsInt());
  }
  const auto pair = [&](const char* key, double fallback) {
    if (!transform.Has(key)) return Eigen::Vector2d(fallback, fallback);
    const tinygltf::Value& member = transform.Get(key);
    return Eigen::Vector2d(member.Get(0).GetNumberAsDouble(), member.Get(1).GetNumberAsDouble());
  };
  const double angle =
      transform.Has("rotation") ? transform.Get("rotation").GetNumberAsDouble() : 0.0;
  // The extension turns counter-clockwise with v downwards: the matrix of the opposite angle.
  coordinates.transform = Eigen::Translation2d(pair("offset", 0.0)) * Eigen::Rotation2Dd(-angle) *
                          Eigen::Scaling(pair("scale", 1.0));
  return coordinates;
}

struct Ignored {
  std::uint64_t blended = 0;
  std::uint64_t unlit = 0;
  std::uint64_t emissive = 0;
  std::uint64_t without_image = 0;
};

void read_base_colour(const std::vector<double>& rgba, Material& material, RepairReport& repairs) {
  const auto clamped = [](double x) { return static_cast<float>(std::clamp(x, 0.0, 1.0)); };
  material.base_color = {clamped(rgba[0]), clamped(rgba[1]), clamped(rgba[2])};
  material.base_alpha = clamped(rgba[3]);
  const bool outside =
      std::any_of(rgba.begin(), rgba.begin() + 3, [](double x) { return x < 0.0 || x > 1.0; });
  repairs.clamped_albedos += outside ? 1 : 0;
}

Material read_material(const tinygltf::Material& from, RepairReport& repairs, Ignored& ignored) {
  Material material;
  material.name = from.name;
  material.double_sided = from.doubleSided;
  material.alpha_mask = from.alphaMode == "MASK";
  material.alpha_cutoff =
      static_cast<float>(std::min(from.alphaCutoff, 2.0));  // above 1: nothing is there
  read_base_colour(from.pbrMetallicRoughness.baseColorFactor, material, repairs);
  const std::vector<double>& emission = from.emissiveFactor;
  const bool emits =
      std::any_of(emission.begin(), emission.end(), [](double x) { return x > 0.0; });
  ignored.blended += from.alphaMode == "BLEND" ? 1 : 0;
  ignored.emissive += emits ? 1 : 0;
  ignored.unlit += from.extensions.contains("KHR_materials_unlit") ? 1 : 0;
  return material;
}

void add_note(RepairReport& repairs, std::uint64_t count, std::string_view what) {
  if (count > 0) repairs.notes.push_back(fmt::format("{} {}", count, what));
}

}  // namespace

std::vector<TextureCoordinates> load_materials(const Document& document, Scene& scene) {
  TextureLoader textures(document, scene);
  std::vector<TextureCoordinates> coordinates;
  Ignored ignored;
  for (const tinygltf::Material& from : document.model().materials) {
    Material material = read_material(from, scene.repairs, ignored);
    TextureCoordinates uv;
    const tinygltf::TextureInfo& texture = from.pbrMetallicRoughness.baseColorTexture;
    if (texture.index >= 0) {
      uv = texture_coordinates(texture);
      material.texture = textures.load(texture.index);
      ignored.without_image += material.texture == kNone ? 1 : 0;
    }
    scene.materials.push_back(std::move(material));
    coordinates.push_back(uv);
  }
  add_note(scene.repairs, scene.repairs.clamped_albedos, "base colours clamped to [0, 1]");
  add_note(scene.repairs, ignored.blended, "materials with alphaMode BLEND treated as opaque");
  add_note(scene.repairs, ignored.unlit, "unlit materials treated as Lambert surfaces");
  add_note(scene.repairs, ignored.emissive, "materials' own emission ignored");
  add_note(scene.repairs, ignored.without_image,
           "base colour textures ignored: their image needs an extension");
  return coordinates;
}

}  // namespace prt::gltf
