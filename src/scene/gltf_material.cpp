#include "scene/gltf_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace prt::gltf {
namespace {

Texture::Wrap wrap_mode(const Value& sampler, const char* key) {
  switch (sampler.whole_or(key, 10497)) {
    case 10497:
      return Texture::Wrap::kRepeat;
    case 33071:
      return Texture::Wrap::kClamp;
    case 33648:
      return Texture::Wrap::kMirror;
    default:
      sampler[key].fail("it is not a wrap mode of glTF");
  }
}

std::optional<Value> extension(const Value& value, const char* name) {
  const std::optional<Value> extensions = value.find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

/// Loads each image once for each pair of wrap modes it is used with.
class TextureLoader {
 public:
  TextureLoader(const Document& document, Scene& scene)
      : root_(document.root()), document_(document), scene_(scene) {
    check_all();
  }

  /// Index into Scene::textures; kNone if the texture has no image that glTF itself knows.
  std::uint32_t load(std::uint32_t texture_index) {
    const Value texture = root_.element("textures", texture_index);
    const std::optional<Value> source = texture.find("source");
    if (!source) return kNone;
    const std::uint32_t image = source->index(root_.count_of("images"), "images");
    Texture::Wrap wrap_u = Texture::Wrap::kRepeat;
    Texture::Wrap wrap_v = Texture::Wrap::kRepeat;
    if (const std::optional<Value> sampler = texture.find("sampler")) {
      const Value json =
          root_.element("samplers", sampler->index(root_.count_of("samplers"), "samplers"));
      wrap_u = wrap_mode(json, "wrapS");
      wrap_v = wrap_mode(json, "wrapT");
    }
    const auto key = std::tuple(image, wrap_u, wrap_v);
    if (const auto known = loaded_.find(key); known != loaded_.end()) return known->second;
    Texture result;
    result.wrap_u = wrap_u;
    result.wrap_v = wrap_v;
    const Value image_json = root_.element("images", image);
    decode_image(image_bytes(image_json), image_json, result);
    scene_.textures.push_back(std::move(result));
    const auto index = static_cast<std::uint32_t>(scene_.textures.size() - 1);
    loaded_.emplace(key, index);
    return index;
  }

 private:
  /// Textures that shading does not need are not decoded, but their references must be sound.
  void check_all() const {
    for (const Value& texture : root_.list("textures")) {
      if (const auto source = texture.find("source")) {
        static_cast<void>(source->index(root_.count_of("images"), "images"));
      }
      if (const auto sampler = texture.find("sampler")) {
        static_cast<void>(sampler->index(root_.count_of("samplers"), "samplers"));
      }
    }
    for (const Value& image : root_.list("images")) {
      if (const auto uri = image.find("uri")) {
        document_.check_uri(*uri);
      } else {
        static_cast<void>(image_view(image));
      }
    }
  }

  [[nodiscard]] std::uint32_t image_view(const Value& image) const {
    return image["bufferView"].index(root_.count_of("bufferViews"), "bufferViews");
  }

  [[nodiscard]] std::vector<std::byte> image_bytes(const Value& image) const {
    if (const std::optional<Value> uri = image.find("uri")) return document_.resource(*uri);
    const std::span<const std::byte> bytes = document_.view(image_view(image));
    return {bytes.begin(), bytes.end()};
  }

  Value root_;
  const Document& document_;
  Scene& scene_;
  std::map<std::tuple<std::uint32_t, Texture::Wrap, Texture::Wrap>, std::uint32_t> loaded_;
};

TextureCoordinates texture_coordinates(const Value& texture_info) {
  TextureCoordinates coordinates;
  std::uint64_t set = texture_info.whole_or("texCoord", 0);
  if (const std::optional<Value> transform = extension(texture_info, "KHR_texture_transform")) {
    set = transform->whole_or("texCoord", set);
    const auto pair = [&](const char* key, double fallback) {
      const std::optional<Value> member = transform->find(key);
      if (!member) return Eigen::Vector2d(fallback, fallback);
      const std::vector<double> numbers = member->numbers(2);
      return Eigen::Vector2d(numbers[0], numbers[1]);
    };
    // The extension turns counter-clockwise with v downwards: the matrix of the opposite angle.
    coordinates.transform = Eigen::Translation2d(pair("offset", 0.0)) *
                            Eigen::Rotation2Dd(-transform->number_or("rotation", 0.0)) *
                            Eigen::Scaling(pair("scale", 1.0));
  }
  if (set > 255) texture_info.fail("its texCoord is not a set of texture coordinates");
  coordinates.set = static_cast<std::uint32_t>(set);
  return coordinates;
}

struct Ignored {
  std::uint64_t blended = 0;
  std::uint64_t unlit = 0;
  std::uint64_t emissive = 0;
  std::uint64_t without_image = 0;
};

void read_base_colour(const Value& factor, Material& material, RepairReport& repairs) {
  const std::vector<double> rgba = factor.numbers(4);
  const auto clamped = [](double x) { return static_cast<float>(std::clamp(x, 0.0, 1.0)); };
  material.base_color = {clamped(rgba[0]), clamped(rgba[1]), clamped(rgba[2])};
  material.base_alpha = clamped(rgba[3]);
  const bool outside =
      std::any_of(rgba.begin(), rgba.begin() + 3, [](double x) { return x < 0.0 || x > 1.0; });
  repairs.clamped_albedos += outside ? 1 : 0;
}

void read_alpha_mode(const Value& json, Material& material, Ignored& ignored) {
  const std::string mode = json.text_or("alphaMode", "OPAQUE");
  material.alpha_mask = mode == "MASK";
  ignored.blended += mode == "BLEND" ? 1 : 0;
  if (!material.alpha_mask && mode != "BLEND" && mode != "OPAQUE") {
    json["alphaMode"].fail(fmt::format("'{}' is not OPAQUE, MASK or BLEND", mode));
  }
  const double cutoff = json.number_or("alphaCutoff", 0.5);
  if (cutoff < 0.0) json["alphaCutoff"].fail("it is negative");
  material.alpha_cutoff = static_cast<float>(std::min(cutoff, 2.0));  // above 1: nothing is there
}

bool emits(const Value& json) {
  const std::optional<Value> factor = json.find("emissiveFactor");
  if (!factor) return false;
  const std::vector<double> rgb = factor->numbers(3);
  return std::any_of(rgb.begin(), rgb.end(), [](double x) { return x > 0.0; });
}

void add_note(RepairReport& repairs, std::uint64_t count, std::string_view what) {
  if (count > 0) repairs.notes.push_back(fmt::format("{} {}", count, what));
}

}  // namespace

std::vector<TextureCoordinates> load_materials(const Document& document, Scene& scene) {
  TextureLoader textures(document, scene);
  std::vector<TextureCoordinates> coordinates;
  Ignored ignored;
  for (const Value& json : document.root().list("materials")) {
    Material material;
    TextureCoordinates uv;
    material.name = json.text_or("name", "");
    material.double_sided = json.boolean_or("doubleSided", false);
    read_alpha_mode(json, material, ignored);
    if (const auto pbr = json.find("pbrMetallicRoughness")) {
      if (const auto factor = pbr->find("baseColorFactor")) {
        read_base_colour(*factor, material, scene.repairs);
      }
      if (const auto texture = pbr->find("baseColorTexture")) {
        uv = texture_coordinates(*texture);
        material.texture = textures.load(
            (*texture)["index"].index(document.root().count_of("textures"), "textures"));
        ignored.without_image += material.texture == kNone ? 1 : 0;
      }
    }
    ignored.emissive += emits(json) ? 1 : 0;
    ignored.unlit += extension(json, "KHR_materials_unlit") ? 1 : 0;
    scene.materials.push_back(material);
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
