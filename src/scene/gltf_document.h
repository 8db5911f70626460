// A glTF file in memory: container, JSON, buffers, all ranges checked. Internal to scene/.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf_json.h"

namespace prt::gltf {

class Document {
 public:
  /// Reads a .glb or .gltf (told apart by content) with all its buffers, and checks version,
  /// required extensions, and every bufferView and accessor. Throws UserError.
  explicit Document(const std::filesystem::path& file);
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  [[nodiscard]] Value root() const { return {json_, name_, ""}; }
  [[nodiscard]] const std::string& name() const { return name_; }

  /// The bytes of a bufferView, from `offset` on. `from` is whom to blame when it does not fit.
  [[nodiscard]] std::span<const std::byte> view(std::uint32_t index) const;

  /// The bytes an URI stands for: a data URI, or a file in the scene's folder or below.
  [[nodiscard]] std::vector<std::byte> resource(const Value& uri) const;
  /// The checks of resource() without reading the file.
  void check_uri(const Value& uri) const;

 private:
  void parse(std::span<const std::byte> bytes);
  void parse_json(std::span<const std::byte> bytes);
  void check_asset() const;
  void check_extensions() const;
  void load_buffers(std::span<const std::byte> binary_chunk, bool has_chunk);
  [[nodiscard]] std::filesystem::path local_file(const Value& uri) const;

  std::filesystem::path file_;
  std::string name_;
  nlohmann::json json_;
  std::vector<std::vector<std::byte>> buffers_;
};

}  // namespace prt::gltf
