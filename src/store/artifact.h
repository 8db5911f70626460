// An artifact in memory: named arrays with units and meaning, and what it was made from. On disk it
// is one HDF5 file (store/hdf5_image.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/types.h"

namespace prt {

enum class ElementType { kInt8, kInt16, kUint8, kUint16, kUint32, kUint64, kFloat32, kFloat64 };
std::size_t element_size(ElementType type);

template <typename T>
constexpr ElementType element_type_of() {
  if constexpr (std::is_same_v<T, std::int8_t>)
    return ElementType::kInt8;
  else if constexpr (std::is_same_v<T, std::int16_t>)
    return ElementType::kInt16;
  else if constexpr (std::is_same_v<T, std::uint8_t>)
    return ElementType::kUint8;
  else if constexpr (std::is_same_v<T, std::uint16_t>)
    return ElementType::kUint16;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return ElementType::kUint32;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return ElementType::kUint64;
  else if constexpr (std::is_same_v<T, float>)
    return ElementType::kFloat32;
  else if constexpr (std::is_same_v<T, double>)
    return ElementType::kFloat64;
  else
    static_assert(sizeof(T) == 0, "not an element type of artifacts");
}

struct Dataset {
  ElementType type = ElementType::kFloat32;
  std::vector<std::uint64_t> dims;  ///< slowest first; row-major
  std::vector<std::byte> bytes;
  std::string units;    ///< "m", "W/m^2", "1" ...
  std::string meaning;  ///< one phrase
};

/// Named arrays plus a JSON object of scalars ("attributes"). std::map keeps one order of names, so
/// that equal artifacts serialise to equal bytes.
struct Artifact {
  std::map<std::string, Dataset> datasets;
  nlohmann::json attributes = nlohmann::json::object();

  /// Adds an array. dims.product() must equal values.size().
  template <typename T>
  void put(const std::string& name, std::span<const T> values, std::vector<std::uint64_t> dims,
           std::string units, std::string meaning) {
    std::uint64_t count = 1;
    for (auto d : dims) count *= d;
    if (count != values.size())
      throw std::logic_error("artifact array " + name + ": shape and size differ");
    Dataset dataset{
        element_type_of<T>(), std::move(dims), {}, std::move(units), std::move(meaning)};
    const auto raw = std::as_bytes(values);
    dataset.bytes.assign(raw.begin(), raw.end());
    datasets[name] = std::move(dataset);
  }
  void put(const std::string& name, const MatrixF& m, std::string units, std::string meaning) {
    put(name, std::span<const float>(m.data(), static_cast<std::size_t>(m.size())),
        {static_cast<std::uint64_t>(m.rows()), static_cast<std::uint64_t>(m.cols())},
        std::move(units), std::move(meaning));
  }
  void put(const std::string& name, const std::vector<Vec3f>& v, std::string units,
           std::string meaning) {
    put(name, std::span<const float>(v.empty() ? nullptr : v[0].data(), v.size() * 3),
        {v.size(), 3}, std::move(units), std::move(meaning));
  }

  [[nodiscard]] bool has(const std::string& name) const { return datasets.contains(name); }
  /// Throws UnsoundData if there is no such array.
  [[nodiscard]] const Dataset& at(const std::string& name) const;

  /// View of an array's values; throws UnsoundData if it is missing or of another type.
  template <typename T>
  [[nodiscard]] std::span<const T> values(const std::string& name) const {
    const Dataset& d = at(name);
    if (d.type != element_type_of<T>())
      throw UnsoundData("array " + name + " has another element type");
    return {reinterpret_cast<const T*>(d.bytes.data()), d.bytes.size() / sizeof(T)};
  }
  template <typename T>
  [[nodiscard]] std::vector<T> vector(const std::string& name) const {
    const auto v = values<T>(name);
    return {v.begin(), v.end()};
  }
  [[nodiscard]] std::vector<Vec3f> points(const std::string& name) const;
  /// Two-dimensional float array as matrix (copy).
  [[nodiscard]] MatrixF matrix(const std::string& name) const;
  /// Scalar from the attributes; throws UnsoundData if missing or of another type.
  template <typename T>
  [[nodiscard]] T attribute(const std::string& name) const {
    const auto it = attributes.find(name);
    if (it == attributes.end()) throw UnsoundData("attribute " + name + " is missing");
    try {
      return it->get<T>();
    } catch (const nlohmann::json::exception&) {
      throw UnsoundData("attribute " + name + " has another type");
    }
  }
};

}  // namespace prt
