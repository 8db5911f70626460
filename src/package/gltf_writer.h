// Builds a .glb: JSON and one binary buffer with an accessor per array. Internal to package/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>
#include <vector>

namespace prt {

class GltfWriter {
 public:
  /// What an array is for: only geometry names a target, as glTF wants it.
  enum class Use { kData, kVertices, kIndices };

  /// The file's JSON; buffers, bufferViews and accessors are filled in by finish().
  nlohmann::json root = nlohmann::json::object();

  /// Appends an array of `components` values per element and returns its accessor. Integers are
  /// stored `normalized` if asked. Throws std::logic_error for an empty array: glTF has none.
  template <typename T>
  std::uint32_t add(std::span<const T> values, unsigned components = 1, Use use = Use::kData,
                    bool normalized = false) {
    return add_accessor(std::as_bytes(values), component_type<T>(), values.size(), components, use,
                        normalized);
  }
  /// Same, for vertex positions: with the bounds that glTF asks for.
  std::uint32_t add_positions(std::span<const float> xyz);
  /// Appends bytes that no accessor describes (images) and returns their bufferView.
  std::uint32_t add_view(std::span<const std::byte> bytes, Use use = Use::kData);

  /// The whole file. Throws UserError when it is beyond the 4 GiB of the container.
  std::vector<std::byte> finish();

 private:
  template <typename T>
  static constexpr int component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    if constexpr (std::is_same_v<T, float>) return 5126;
  }
  std::uint32_t add_accessor(std::span<const std::byte> bytes, int component_type,
                             std::size_t values, unsigned components, Use use, bool normalized);

  std::vector<std::byte> binary_;
  nlohmann::json views_ = nlohmann::json::array();
  nlohmann::json accessors_ = nlohmann::json::array();
};

}  // namespace prt
