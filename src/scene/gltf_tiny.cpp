#include "scene/gltf_tiny.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "scene/gltf_check.h"

namespace prt::gltf {
namespace {

using Json = nlohmann::json;

/// glTF's own JSON is about ten deep, and tinygltf reads extensions recursively.
constexpr int kMaxDepth = 64;

/// The sections that the loader takes from tinygltf.
constexpr std::array<const char*, 12> kSections = {
    "asset",       "scene",     "scenes",   "nodes",  "meshes",   "accessors",
    "bufferViews", "materials", "textures", "images", "samplers", "cameras"};
constexpr const char* kLights = "KHR_lights_punctual";
constexpr std::array<const char*, 3> kExtensions = {kLights, "KHR_texture_transform",
                                                    "KHR_materials_unlit"};

/// tinygltf takes 1.0 for no integer, and cuts the integers of extensions to 32 bits.
Json number(const Json& json, bool in_extension) {
  const double value = json.get<double>();
  const double limit = in_extension ? std::numeric_limits<int>::max() : 0x1p53;
  if (value != std::floor(value) || std::abs(value) > limit) return value;
  if (value < 0.0) return static_cast<std::int64_t>(value);
  return static_cast<std::uint64_t>(value);
}

/// A copy without extras and foreign extensions.
Json cleaned(const Json& json, const Document& document, bool in_extension, int depth) {
  if (depth > kMaxDepth) fail(document.name(), "its JSON is nested too deeply");
  if (json.is_array()) {
    Json copy = Json::array();
    for (const Json& item : json) copy.push_back(cleaned(item, document, in_extension, depth + 1));
    return copy;
  }
  if (!json.is_object()) return json.is_number() ? number(json, in_extension) : json;
  Json copy = Json::object();
  for (const auto& [key, item] : json.items()) {
    if (key == "extras") continue;
    if (key != "extensions") {
      copy[key] = cleaned(item, document, in_extension, depth + 1);
    } else if (item.is_object()) {
      for (const char* name : kExtensions) {
        if (const auto found = item.find(name); found != item.end()) {
          copy[key][name] = cleaned(*found, document, true, depth + 1);
        }
      }
    }
  }
  return copy;
}

/// Which images are base colours.
std::vector<bool> needed_images(const Value& root) {
  std::vector<bool> needed(root.count_of("images"), false);
  for (const Value& material : root.list("materials")) {
    const auto pbr = material.find("pbrMetallicRoughness");
    const auto info = pbr ? pbr->find("baseColorTexture") : std::nullopt;
    if (!info) continue;
    const Value texture =
        root.element("textures", (*info)["index"].index(root.count_of("textures"), "textures"));
    if (const auto source = texture.find("source")) {
      needed[source->index(needed.size(), "images")] = true;
    }
  }
  return needed;
}

/// All that tinygltf can ask for: "buffer/N" and "image/N", names of our own making.
struct Resources {
  const Document& document;
  std::vector<std::vector<unsigned char>> buffers;
  std::vector<bool> needed;

  std::optional<std::size_t> number_of(std::string_view name, std::string_view kind,
                                       std::size_t count) const {
    std::size_t number = 0;
    if (!name.starts_with(kind)) return std::nullopt;
    const char* end = name.data() + name.size();
    const auto result = std::from_chars(name.data() + kind.size(), end, number);
    if (result.ec != std::errc() || result.ptr != end || number >= count) return std::nullopt;
    return number;
  }
  [[nodiscard]] std::optional<std::size_t> buffer(std::string_view name) const {
    return number_of(name, "buffer/", buffers.size());
  }
  [[nodiscard]] std::optional<std::size_t> image(std::string_view name) const {
    const auto number = number_of(name, "image/", needed.size());
    return number && needed[*number] ? number : std::nullopt;
  }
};

Resources& resources(void* user_data) { return *static_cast<Resources*>(user_data); }

bool resource_exists(const std::string& name, void* user_data) {
  return resources(user_data).buffer(name) || resources(user_data).image(name);
}

bool read_resource(std::vector<unsigned char>* bytes, std::string* /*error*/,
                   const std::string& name, void* user_data) {
  Resources& all = resources(user_data);
  if (const auto buffer = all.buffer(name)) {
    *bytes = std::move(all.buffers[*buffer]);
    return true;
  }
  const auto image = all.image(name);
  if (!image) return false;
  *bytes = all.document.resource(all.document.root().element("images", *image)["uri"]);
  return true;
}

/// What TinyGLTF reads instead of files. Newer versions want a callback for everything.
template <typename Callbacks>
Callbacks callbacks(Resources& all) {
  Callbacks files{};
  files.FileExists = resource_exists;
  files.ExpandFilePath = [](const std::string& path, void*) { return path; };
  files.ReadWholeFile = read_resource;
  files.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                            void*) { return false; };
  if constexpr (requires { files.GetFileSizeInBytes; }) {
    // It asks to refuse large files; what it may read was read and judged before.
    files.GetFileSizeInBytes = [](std::size_t* size, std::string*, const std::string&, void*) {
      *size = 0;
      return true;
    };
  }
  files.user_data = &all;
  return files;
}

/// Keeps the encoded bytes: gltf_material decodes what it needs, and packages want them as they
/// are.
bool keep_encoded(tinygltf::Image* image, int index, std::string* /*error*/,
                  std::string* /*warning*/, int /*width*/, int /*height*/,
                  const unsigned char* bytes, int size, void* user_data) {
  if (!resources(user_data).needed[static_cast<std::size_t>(index)]) return true;
  image->image.assign(bytes, bytes + size);
  image->as_is = true;
  return true;
}

std::string text_for_tinygltf(const Document& document, const Resources& all) {
  const Value root = document.root();
  Json json = Json::object();
  for (const char* section : kSections) {
    if (const auto member = root.find(section)) {
      json[section] = cleaned(member->json(), document, false, 0);
    }
  }
  if (const auto lights = extension(root, kLights)) {
    json["extensions"][kLights] = cleaned(lights->json(), document, true, 0);
  }
  json["asset"]["version"] = "2.0";
  for (std::size_t i = 0; i < all.buffers.size(); ++i) {
    json["buffers"].push_back(
        {{"byteLength", all.buffers[i].size()}, {"uri", fmt::format("buffer/{}", i)}});
  }
  for (std::size_t i = 0; i < all.needed.size(); ++i) {
    Json& image = json["images"][i];
    if (image.contains("uri")) image["uri"] = fmt::format("image/{}", i);
  }
  return json.dump();
}

}  // namespace

std::unique_ptr<tinygltf::Model> tiny_model(const Document& document,
                                            std::vector<std::vector<unsigned char>> buffers) {
  Resources all{document, std::move(buffers), needed_images(document.root())};
  const std::string text = text_for_tinygltf(document, all);
  if (text.size() > std::numeric_limits<unsigned>::max()) {
    fail(document.name(), "its JSON is larger than 4 GiB");
  }
  tinygltf::TinyGLTF reader;
  reader.SetImageLoader(keep_encoded, &all);
  reader.SetFsCallbacks(callbacks<tinygltf::FsCallbacks>(all));
  auto model = std::make_unique<tinygltf::Model>();
  std::string error;
  std::string warning;
  bool read = false;
  try {
    read = reader.LoadASCIIFromString(model.get(), &error, &warning, text.data(),
                                      static_cast<unsigned>(text.size()), "");
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (read) return model;
  while (!error.empty() && error.back() == '\n') error.pop_back();
  fail(document.name(), fmt::format("tinygltf cannot read it: {}", error));
}

}  // namespace prt::gltf
