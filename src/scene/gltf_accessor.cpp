#include "scene/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace prt::gltf {
namespace {

/// An array of zeros costs the file nothing, so its length is bounded.
constexpr std::uint64_t kMaxZeros = std::uint64_t{1} << 20;

std::size_t component_size(const Value& value, std::uint64_t type) {
  switch (static_cast<ComponentType>(type)) {
    case ComponentType::kByte:
    case ComponentType::kUnsignedByte:
      return 1;
    case ComponentType::kShort:
    case ComponentType::kUnsignedShort:
      return 2;
    case ComponentType::kUnsignedInt:
    case ComponentType::kFloat:
      return 4;
  }
  value.fail(fmt::format("{} is not a component type of glTF", type));
}

struct Shape {
  std::string_view name;
  unsigned rows;
  unsigned columns;
};
constexpr std::array<Shape, 7> kShapes = {{{"SCALAR", 1, 1},
                                           {"VEC2", 2, 1},
                                           {"VEC3", 3, 1},
                                           {"VEC4", 4, 1},
                                           {"MAT2", 2, 2},
                                           {"MAT3", 3, 3},
                                           {"MAT4", 4, 4}}};

template <typename T>
T load(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint32_t load_unsigned(ComponentType type, const std::byte* bytes) {
  if (type == ComponentType::kUnsignedByte) return load<std::uint8_t>(bytes);
  if (type == ComponentType::kUnsignedShort) return load<std::uint16_t>(bytes);
  return load<std::uint32_t>(bytes);
}

}  // namespace

Accessor::Accessor(const Document& document, std::uint32_t index)
    : json_(document.root().element("accessors", index)) {
  read_type();
  const std::uint64_t count = json_["count"].whole();
  if (count == 0 || count > 0xffffffffU) {
    json_.fail(fmt::format("its count {} is not between 1 and 2^32 - 1", count));
  }
  count_ = count;
  normalized_ = json_.boolean_or("normalized", false);
  if (json_.find("bufferView")) {
    values_ = array(document, json_, count_, element_size_, true);
  } else if (count > kMaxZeros) {
    json_.fail(fmt::format("it has {} elements but no bufferView", count));
  }
  if (const std::optional<Value> sparse = json_.find("sparse")) read_sparse(document, *sparse);
}

void Accessor::read_type() {
  const Value component = json_["componentType"];
  const std::size_t size = component_size(component, component.whole());
  type_ = static_cast<ComponentType>(component.whole());
  const Value type = json_["type"];
  const std::string name = type.text();
  const auto* shape =
      std::find_if(kShapes.begin(), kShapes.end(), [&](const Shape& s) { return s.name == name; });
  if (shape == kShapes.end()) type.fail(fmt::format("'{}' is not a type of glTF", name));
  components_ = shape->rows * shape->columns;
  const std::size_t column = shape->rows * size;
  // Columns of matrices begin at multiples of four bytes.
  element_size_ = shape->columns == 1 ? column : (column + 3) / 4 * 4 * shape->columns;
}

Accessor::Array Accessor::array(const Document& document, const Value& where, std::size_t count,
                                std::size_t element_size, bool strided) const {
  const Value view = where["bufferView"];
  const std::uint32_t index = view.index(document.root().count_of("bufferViews"), "bufferViews");
  const std::span<const std::byte> bytes = document.view(index);
  std::size_t stride = element_size;
  const Value view_json = document.root().element("bufferViews", index);
  if (const auto given = strided ? view_json.find("byteStride") : std::nullopt) {
    stride = given->whole();
    if (stride < element_size || stride > 252) {
      given->fail(
          fmt::format("a stride of {} does not fit elements of {} bytes", stride, element_size));
    }
  }
  const std::uint64_t offset = where.whole_or("byteOffset", 0);
  const std::uint64_t extent = stride * (count - 1) + element_size;
  if (offset > bytes.size() || extent > bytes.size() - offset) {
    where.fail(
        fmt::format("{} elements of {} bytes from byte {} on are out of range: bufferView {} "
                    "has {} bytes",
                    count, stride, offset, index, bytes.size()));
  }
  return {bytes.subspan(offset, extent), stride};
}

void Accessor::read_sparse(const Document& document, const Value& sparse) {
  const std::uint64_t count = sparse["count"].whole();
  if (count == 0 || count > count_) {
    sparse.fail(fmt::format("its count {} is not between 1 and {}", count, count_));
  }
  const Value indices = sparse["indices"];
  const Value component = indices["componentType"];
  const std::size_t size = component_size(component, component.whole());
  const auto type = static_cast<ComponentType>(component.whole());
  if (type != ComponentType::kUnsignedByte && type != ComponentType::kUnsignedShort &&
      type != ComponentType::kUnsignedInt) {
    component.fail("indices must be unsigned integers");
  }
  const Array array_of_indices = array(document, indices, count, size, false);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t at = load_unsigned(type, array_of_indices.bytes.data() + i * size);
    if (at >= count_ || (i > 0 && at <= sparse_indices_.back())) {
      indices.fail("they must increase and lie within the accessor");
    }
    sparse_indices_.push_back(at);
  }
  sparse_values_ = array(document, sparse["values"], count, element_size_, false);
}

const std::byte* Accessor::element_bytes(std::size_t element) const {
  if (!sparse_indices_.empty()) {
    const auto found = std::lower_bound(sparse_indices_.begin(), sparse_indices_.end(), element);
    if (found != sparse_indices_.end() && *found == element) {
      const auto position = static_cast<std::size_t>(found - sparse_indices_.begin());
      return sparse_values_.bytes.data() + position * sparse_values_.stride;
    }
  }
  return values_.bytes.empty() ? nullptr : values_.bytes.data() + element * values_.stride;
}

double Accessor::real(std::size_t element, unsigned component) const {
  const std::byte* bytes = element_bytes(element);
  if (bytes == nullptr) return 0.0;
  const auto scaled = [&](auto value, double maximum) {
    const double number = static_cast<double>(value);
    return normalized_ ? std::max(number / maximum, -1.0) : number;
  };
  switch (type_) {
    case ComponentType::kByte:
      return scaled(load<std::int8_t>(bytes + component), 127.0);
    case ComponentType::kUnsignedByte:
      return scaled(load<std::uint8_t>(bytes + component), 255.0);
    case ComponentType::kShort:
      return scaled(load<std::int16_t>(bytes + 2UL * component), 32767.0);
    case ComponentType::kUnsignedShort:
      return scaled(load<std::uint16_t>(bytes + 2UL * component), 65535.0);
    case ComponentType::kUnsignedInt:
      return load<std::uint32_t>(bytes + 4UL * component);
    case ComponentType::kFloat:
      return load<float>(bytes + 4UL * component);
  }
  return 0.0;
}

std::uint32_t Accessor::integer(std::size_t element) const {
  const std::byte* bytes = element_bytes(element);
  return bytes == nullptr ? 0 : load_unsigned(type_, bytes);
}

}  // namespace prt::gltf
