// Typed, bounds-checked access to the arrays of a glTF file. Internal to scene/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/gltf_document.h"

namespace prt::gltf {

/// The numbers of the file's "componentType".
enum class ComponentType {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};

/// Reads straight from the document's buffers: it allocates nothing that the file has not paid for.
class Accessor {
 public:
  /// Checks type, counts and ranges, sparse part included. Throws UserError.
  Accessor(const Document& document, std::uint32_t index);

  [[nodiscard]] std::size_t count() const { return count_; }
  /// 1 for SCALAR, 3 for VEC3, ...
  [[nodiscard]] unsigned components() const { return components_; }
  [[nodiscard]] ComponentType component_type() const { return type_; }
  [[nodiscard]] const Value& value() const { return json_; }

  /// Component of an element as a real number; integers are scaled if "normalized".
  [[nodiscard]] double real(std::size_t element, unsigned component) const;
  /// The only component of an element of an unsigned integer array.
  [[nodiscard]] std::uint32_t integer(std::size_t element) const;

 private:
  struct Array {
    std::span<const std::byte> bytes;  ///< empty: all zero
    std::size_t stride = 0;
  };

  void read_type();
  [[nodiscard]] Array array(const Document& document, const Value& where, std::size_t count,
                            std::size_t element_size, bool strided) const;
  void read_sparse(const Document& document, const Value& sparse);
  [[nodiscard]] const std::byte* element_bytes(std::size_t element) const;

  Value json_;
  ComponentType type_ = ComponentType::kFloat;
  unsigned components_ = 1;
  std::size_t element_size_ = 0;
  std::size_t count_ = 0;
  bool normalized_ = false;
  Array values_;
  std::vector<std::uint32_t> sparse_indices_;  ///< increasing
  Array sparse_values_;
};

}  // namespace prt::gltf
