// Small glTF files made by the tests themselves, sound or not.
#pragma once

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "scene/load.h"

namespace prt::testing {

/// A folder that is gone with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "prt_scene_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }

 private:
  std::filesystem::path path_;
};

inline std::string base64(const std::string& bytes) {
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63U];
    }
  }
  return text;
}

/// JSON and one buffer, built up piece by piece; `json` may be spoilt at will.
struct GltfWriter {
  using Json = nlohmann::json;
  Json json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}],
                              "nodes": [], "meshes": [], "accessors": [], "bufferViews": []})");
  std::string binary;

  std::size_t append(const char* array, Json value) {
    json[array].push_back(std::move(value));
    return json[array].size() - 1;
  }

  std::size_t add_view(const std::string& bytes) {
    binary.resize((binary.size() + 3) / 4 * 4);
    const std::size_t offset = binary.size();
    binary += bytes;
    return append("bufferViews",
                  {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
  }

  template <typename T>
  static int component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    return 5126;
  }

  template <typename T>
  static std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
  }

  template <typename T>
  std::size_t add_accessor(const std::vector<T>& values, const std::string& type) {
    const std::size_t components = type == "SCALAR" ? 1 : static_cast<std::size_t>(type[3] - '0');
    return append("accessors", {{"bufferView", add_view(bytes_of(values))},
                                {"componentType", component_type<T>()},
                                {"count", values.size() / components},
                                {"type", type}});
  }

  /// A mesh of one primitive, with a node of its own in the scene. Returns the node.
  std::size_t add_mesh_node(Json primitive, Json node = Json::object()) {
    node["mesh"] = append("meshes", {{"primitives", Json::array({std::move(primitive)})}});
    return add_node(std::move(node));
  }

  std::size_t add_node(Json node) {
    const std::size_t index = append("nodes", std::move(node));
    json["scenes"][0]["nodes"].push_back(index);
    return index;
  }

  [[nodiscard]] std::string glb() const {
    Json with_buffer = json;
    if (!with_buffer.contains("buffers") && !binary.empty()) {
      with_buffer["buffers"] = Json::array({{{"byteLength", binary.size()}}});
    }
    return glb_of(with_buffer.dump(), binary);
  }

  static std::string glb_of(std::string text, std::string chunk) {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    chunk.resize((chunk.size() + 3) / 4 * 4);
    std::string bytes;
    const auto word = [&](std::size_t value) {
      const auto narrow = static_cast<std::uint32_t>(value);
      bytes.append(reinterpret_cast<const char*>(&narrow), 4);
    };
    word(0x46546C67);
    word(2);
    word(12 + 8 + text.size() + (chunk.empty() ? 0 : 8 + chunk.size()));
    word(text.size());
    word(0x4E4F534A);
    bytes += text;
    if (chunk.empty()) return bytes;
    word(chunk.size());
    word(0x004E4942);
    return bytes + chunk;
  }

  /// The .gltf's text, its buffer at `uri`.
  [[nodiscard]] std::string gltf(const std::string& uri) const {
    Json with_buffer = json;
    with_buffer["buffers"] = Json::array({{{"byteLength", binary.size()}, {"uri", uri}}});
    return with_buffer.dump();
  }

  [[nodiscard]] Scene load() const {
    const TemporaryFolder folder;
    return load_scene(folder.write("scene.glb", glb()));
  }
};

/// Corners of the unit square in the plane z = 0, counter-clockwise seen from +z.
inline const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
inline const std::vector<float> kSquareUvs = {0, 0, 1, 0, 1, 1, 0, 1};
inline const std::vector<std::uint16_t> kSquareIndices = {0, 1, 2, 0, 2, 3};

/// A file with one square; its accessors: 0 positions, 1 indices, 2 normals, 3 uvs.
inline GltfWriter square_file(GltfWriter::Json node = GltfWriter::Json::object()) {
  GltfWriter writer;
  writer.add_accessor(kSquare, "VEC3");
  writer.add_accessor(kSquareIndices, "SCALAR");
  writer.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  writer.add_accessor(kSquareUvs, "VEC2");
  writer.add_mesh_node(
      {{"attributes", {{"POSITION", 0}, {"NORMAL", 2}, {"TEXCOORD_0", 3}}}, {"indices", 1}},
      std::move(node));
  return writer;
}

/// PNG (lossless) and JPEG files of an image with 4 channels.
std::string png(int width, int height, const std::vector<std::uint8_t>& rgba);
std::string jpeg(int width, int height, const std::vector<std::uint8_t>& rgba);

/// Gives material 0 (made if need be) the image as its base colour texture.
void set_texture(GltfWriter& writer, const std::string& image);

}  // namespace prt::testing
