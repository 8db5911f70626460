#include "package/matrix_list.h"

#include <fmt/format.h>

#include <cstring>

#include "scene/gltf_accessor.h"

namespace prt {
namespace {

using nlohmann::json;

struct Pools {
  std::vector<std::int8_t> int8;
  std::vector<std::int16_t> int16;
  std::vector<float> float32;
  std::vector<float> scales;
};

template <typename T>
void append(std::vector<T>& pool, const std::vector<T>& values) {
  pool.insert(pool.end(), values.begin(), values.end());
}

template <typename T>
void put(json& list, const char* key, const std::vector<T>& pool, GltfWriter& writer) {
  if (pool.empty()) return;
  const bool normalized = !std::is_same_v<T, float>;
  list[key] = writer.add(std::span(pool), 1, GltfWriter::Use::kData, normalized);
}

template <typename T>
std::vector<T> take_pool(const gltf::Document& document, const gltf::Value& list, const char* key) {
  const auto accessor = list.find(key);
  return accessor ? read_array<T>(document, *accessor) : std::vector<T>();
}

/// The next `count` values of a pool.
template <typename T>
std::vector<T> take(const std::vector<T>& pool, std::size_t& used, std::uint64_t count,
                    const gltf::Value& shape) {
  if (count > pool.size() - used) shape.fail("its values are beyond the end of their accessor");
  const auto begin = pool.begin() + static_cast<std::ptrdiff_t>(used);
  used += count;
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

std::uint32_t side(double value, const gltf::Value& shape) {
  if (!(value >= 0.0 && value < 4294967296.0 && value == std::floor(value))) {
    shape.fail("should be rows, columns and bits");
  }
  return static_cast<std::uint32_t>(value);
}

template <typename T>
constexpr gltf::ComponentType component_type() {
  if constexpr (std::is_same_v<T, std::int8_t>) return gltf::ComponentType::kByte;
  if constexpr (std::is_same_v<T, std::int16_t>) return gltf::ComponentType::kShort;
  if constexpr (std::is_same_v<T, std::uint16_t>) return gltf::ComponentType::kUnsignedShort;
  if constexpr (std::is_same_v<T, std::uint32_t>) return gltf::ComponentType::kUnsignedInt;
  if constexpr (std::is_same_v<T, float>) return gltf::ComponentType::kFloat;
}

}  // namespace

template <typename T>
std::vector<T> read_array(const gltf::Document& document, const gltf::Value& accessor,
                          unsigned components) {
  const gltf::Value root = document.root();
  const gltf::Accessor array(document, accessor.index(root.count_of("accessors"), "accessors"));
  if (array.component_type() != component_type<T>() || array.components() != components) {
    accessor.fail("its accessor has another type than this array");
  }
  const gltf::Value& json = array.value();
  if (json.find("sparse") || !json.find("bufferView")) {
    accessor.fail("its accessor must have all its values in one bufferView");
  }
  const std::uint32_t view = json["bufferView"].index(root.count_of("bufferViews"), "bufferViews");
  if (root.element("bufferViews", view).find("byteStride")) {
    accessor.fail("its accessor must have no stride");
  }
  // The accessor has checked that all its elements lie within the view.
  const auto bytes = document.view(view).subspan(json.whole_or("byteOffset", 0));
  std::vector<T> values(array.count() * components);
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

template std::vector<std::int8_t> read_array(const gltf::Document&, const gltf::Value&, unsigned);
template std::vector<std::int16_t> read_array(const gltf::Document&, const gltf::Value&, unsigned);
template std::vector<std::uint16_t> read_array(const gltf::Document&, const gltf::Value&, unsigned);
template std::vector<std::uint32_t> read_array(const gltf::Document&, const gltf::Value&, unsigned);
template std::vector<float> read_array(const gltf::Document&, const gltf::Value&, unsigned);

json write_matrices(std::span<const QuantisedMatrix* const> matrices, GltfWriter& writer) {
  json list = {{"shapes", json::array()}};
  Pools pools;
  for (const QuantisedMatrix* m : matrices) {
    list["shapes"].push_back({m->rows, m->cols, m->bits});
    append(pools.int8, m->int8);
    append(pools.int16, m->int16);
    append(pools.float32, m->float32);
    const bool has_scales = m->bits != 32 && m->rows > 0 && m->cols > 0;
    if (has_scales) append(pools.scales, m->scales);
  }
  put(list, "int8", pools.int8, writer);
  put(list, "int16", pools.int16, writer);
  put(list, "float32", pools.float32, writer);
  put(list, "scales", pools.scales, writer);
  return list;
}

std::vector<QuantisedMatrix> read_matrices(const gltf::Document& document,
                                           const gltf::Value& list) {
  const Pools pools{take_pool<std::int8_t>(document, list, "int8"),
                    take_pool<std::int16_t>(document, list, "int16"),
                    take_pool<float>(document, list, "float32"),
                    take_pool<float>(document, list, "scales")};
  std::size_t used8 = 0;
  std::size_t used16 = 0;
  std::size_t used32 = 0;
  std::size_t used_scales = 0;
  std::vector<QuantisedMatrix> matrices;
  for (const gltf::Value& shape : list.list("shapes")) {
    const std::vector<double> numbers = shape.numbers(3);
    QuantisedMatrix m;
    m.rows = side(numbers[0], shape);
    m.cols = side(numbers[1], shape);
    m.bits = numbers[2] == 8.0 ? 8 : numbers[2] == 16.0 ? 16 : 32;
    if (numbers[2] != m.bits) shape.fail("bits must be 8, 16 or 32");
    const std::uint64_t size = std::uint64_t{m.rows} * m.cols;
    if (m.bits == 8) m.int8 = take(pools.int8, used8, size, shape);
    if (m.bits == 16) m.int16 = take(pools.int16, used16, size, shape);
    if (m.bits == 32) m.float32 = take(pools.float32, used32, size, shape);
    if (size > 0) {
      m.scales = m.bits == 32 ? std::vector<float>(m.rows, 1.0F)
                              : take(pools.scales, used_scales, m.rows, shape);
    }
    matrices.push_back(std::move(m));
  }
  if (used8 != pools.int8.size() || used16 != pools.int16.size() ||
      used32 != pools.float32.size() || used_scales != pools.scales.size()) {
    list.fail("its accessors hold more values than its shapes need");
  }
  return matrices;
}

}  // namespace prt
