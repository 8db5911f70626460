#include "scene/gltf_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

namespace prt::gltf {
namespace {

void check_primitive(const Value& primitive, const Value& root) {
  const std::uint64_t mode = primitive.whole_or("mode", 4);
  if (mode > 6) primitive["mode"].fail(fmt::format("{} is not a mode of glTF", mode));
  check_index(primitive, "indices", root, "accessors");
  check_index(primitive, "material", root, "materials");
  const Value attributes = primitive["attributes"];
  for (const std::string& name : attributes.keys()) {
    check_index(attributes, name.c_str(), root, "accessors");
  }
  static_cast<void>(primitive.count_of("targets"));
}

void check_texture_info(const Value& info, const Value& root) {
  static_cast<void>(info["index"].index(root.count_of("textures"), "textures"));
  std::uint64_t set = info.whole_or("texCoord", 0);
  if (const auto transform = extension(info, "KHR_texture_transform")) {
    set = std::max(set, transform->whole_or("texCoord", set));
    static_cast<void>(transform->number_or("rotation", 0.0));
    for (const char* key : {"offset", "scale"}) {
      if (const auto pair = transform->find(key)) static_cast<void>(pair->numbers(2));
    }
  }
  if (set > 255) info.fail("its texCoord is not a set of texture coordinates");
}

void check_material(const Value& material, const Value& root) {
  static_cast<void>(material.text_or("name", ""));
  static_cast<void>(material.boolean_or("doubleSided", false));
  const std::string mode = material.text_or("alphaMode", "OPAQUE");
  if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND") {
    material["alphaMode"].fail(fmt::format("'{}' is not OPAQUE, MASK or BLEND", mode));
  }
  if (material.number_or("alphaCutoff", 0.5) < 0.0) material["alphaCutoff"].fail("it is negative");
  if (const auto emission = material.find("emissiveFactor")) {
    static_cast<void>(emission->numbers(3));
  }
  static_cast<void>(extension(material, "KHR_materials_unlit"));
  const auto pbr = material.find("pbrMetallicRoughness");
  if (!pbr) return;
  if (const auto factor = pbr->find("baseColorFactor")) static_cast<void>(factor->numbers(4));
  if (const auto texture = pbr->find("baseColorTexture")) check_texture_info(*texture, root);
}

void check_image(const Value& image, const Document& document) {
  if (const auto uri = image.find("uri")) {
    if (image.find("bufferView")) image.fail("it has both a 'uri' and a 'bufferView'");
    document.check_uri(*uri);
    return;
  }
  const std::uint32_t view =
      image["bufferView"].index(document.root().count_of("bufferViews"), "bufferViews");
  const std::size_t size = document.view(view).size();
  if (size == 0) image.fail("the image is empty");
  if (size > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    image.fail("the image is larger than 2 GiB");
  }
}

void check_sampler(const Value& sampler) {
  static constexpr std::array<std::uint64_t, 3> kModes = {10497, 33071, 33648};
  for (const char* key : {"wrapS", "wrapT"}) {
    const std::uint64_t mode = sampler.whole_or(key, kModes[0]);
    if (std::find(kModes.begin(), kModes.end(), mode) == kModes.end()) {
      sampler[key].fail("it is not a wrap mode of glTF");
    }
  }
}

void check_camera(const Value& camera) {
  const std::string type = camera["type"].text();
  if (type == "perspective") {
    const Value perspective = camera["perspective"];
    const double fov = perspective["yfov"].number();
    if (!(fov > 0.0) || fov >= std::numbers::pi) {
      perspective.fail("yfov must lie between 0 and pi");
    }
    static_cast<void>(perspective["znear"].number());
  } else if (type == "orthographic") {
    const Value orthographic = camera["orthographic"];
    for (const char* key : {"xmag", "ymag", "zfar", "znear"}) {
      static_cast<void>(orthographic[key].number());
    }
  } else {
    camera["type"].fail(fmt::format("'{}' is not perspective or orthographic", type));
  }
}

void check_light(const Value& light) {
  static_cast<void>(light.text_or("name", ""));
  const std::string type = light["type"].text();
  if (type == "spot") {
    const Value spot = light["spot"];
    const double inner = spot.number_or("innerConeAngle", 0.0);
    const double outer = spot.number_or("outerConeAngle", std::numbers::pi / 4.0);
    // The slack is for half a right angle's double, written with few digits.
    if (inner < 0.0 || inner >= outer || outer > std::numbers::pi / 2.0 + 1e-6) {
      light.fail("its cone angles must satisfy 0 <= inner < outer <= pi/2");
    }
  } else if (type != "point" && type != "directional") {
    light["type"].fail(fmt::format("'{}' is not point, spot or directional", type));
  }
  bool sound = light.number_or("intensity", 1.0) >= 0.0;
  if (const auto colour = light.find("color")) {
    const std::vector<double> rgb = colour->numbers(3);
    sound = sound && std::all_of(rgb.begin(), rgb.end(), [](double x) { return x >= 0.0; });
  }
  if (!sound) light.fail("its intensity and color must be finite and not negative");
}

}  // namespace

std::optional<Value> extension(const Value& value, const char* name) {
  const std::optional<Value> extensions = value.find("extensions");
  std::optional<Value> found = extensions ? extensions->find(name) : std::nullopt;
  if (found) static_cast<void>(found->find(""));  // it should be an object
  return found;
}

void check_index(const Value& holder, const char* key, const Value& root, const char* array) {
  if (const auto member = holder.find(key)) {
    static_cast<void>(member->index(root.count_of(array), array));
  }
}

void check_contents(const Document& document) {
  const Value root = document.root();
  check_nodes(root);
  for (const Value& mesh : root.list("meshes")) {
    for (const Value& primitive : mesh.list("primitives")) check_primitive(primitive, root);
  }
  for (const Value& material : root.list("materials")) check_material(material, root);
  for (const Value& texture : root.list("textures")) {
    check_index(texture, "source", root, "images");
    check_index(texture, "sampler", root, "samplers");
  }
  for (const Value& image : root.list("images")) check_image(image, document);
  for (const Value& sampler : root.list("samplers")) check_sampler(sampler);
  for (const Value& camera : root.list("cameras")) check_camera(camera);
  if (const auto lights = extension(root, "KHR_lights_punctual")) {
    for (const Value& light : lights->list("lights")) check_light(light);
  }
}

}  // namespace prt::gltf
