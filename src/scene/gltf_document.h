// A glTF file in memory: container, JSON and buffers checked by us, then read by tinygltf. Internal
// to scene/.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf_json.h"

namespace tinygltf {
class Model;
}

namespace prt::gltf {

class Document {
 public:
  /// Reads a .glb or .gltf (told apart by content) with all its buffers, and checks version,
  /// required extensions, every bufferView and accessor, and gltf_check.h's list before tinygltf
  /// sees any of it. Throws UserError.
  explicit Document(const std::filesystem::path& file);
  ~Document();
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  [[nodiscard]] Value root() const { return {json_, name_, ""}; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// What tinygltf read: all references lie in range, and no node is its own ancestor. Of the
  /// images it holds the encoded bytes (gltf_tiny.h).
  [[nodiscard]] const tinygltf::Model& model() const { return *model_; }

  /// The bytes of a bufferView, from `offset` on. `from` is whom to blame when it does not fit.
  [[nodiscard]] std::span<const std::byte> view(std::uint32_t index) const;

  /// The bytes an URI stands for: a data URI, or a file in the scene's folder or below.
  [[nodiscard]] std::vector<unsigned char> resource(const Value& uri) const;
  /// The checks of resource() without reading the file.
  void check_uri(const Value& uri) const;

 private:
  using Bytes = std::vector<unsigned char>;
  /// Result: the buffers.
  std::vector<Bytes> parse(std::span<const std::byte> bytes);
  void parse_json(std::span<const std::byte> bytes);
  void check_asset() const;
  void check_extensions() const;
  [[nodiscard]] std::vector<Bytes> load_buffers(std::span<const std::byte> binary_chunk,
                                                bool has_chunk) const;
  void check() const;
  [[nodiscard]] std::filesystem::path local_file(const Value& uri) const;

  std::filesystem::path file_;
  std::string name_;
  nlohmann::json json_;
  std::vector<std::span<const std::byte>> buffers_;
  std::unique_ptr<tinygltf::Model> model_;
};

}  // namespace prt::gltf
