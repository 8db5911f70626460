#include "scene/gltf_json.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "scene/whole_file.h"

namespace prt::gltf {

void fail(const std::string& file, std::string_view what) {
  refuse(fmt::format("scene {}: {}", file, what));
}

void Value::fail(std::string_view what) const {
  gltf::fail(*file_, fmt::format("{}: {}", path_.empty() ? "its JSON" : path_, what));
}

void Value::require_object() const {
  if (!json_->is_object()) fail("should be an object");
}

std::optional<Value> Value::find(const char* key) const {
  require_object();
  const auto member = json_->find(key);
  if (member == json_->end()) return std::nullopt;
  return Value(*member, *file_, path_.empty() ? key : fmt::format("{}.{}", path_, key));
}

Value Value::operator[](const char* key) const {
  std::optional<Value> member = find(key);
  if (!member) fail(fmt::format("'{}' is missing", key));
  return *member;
}

std::vector<Value> Value::list(const char* key) const {
  std::vector<Value> elements;
  const std::size_t count = count_of(key);
  elements.reserve(count);
  for (std::size_t i = 0; i < count; ++i) elements.push_back(element(key, i));
  return elements;
}

std::size_t Value::count_of(const char* key) const {
  const std::optional<Value> member = find(key);
  if (!member) return 0;
  if (!member->json_->is_array()) member->fail("should be an array");
  return member->json_->size();
}

Value Value::element(const char* key, std::size_t index) const {
  const Value array = (*this)[key];
  return {array.json_->at(index), *file_, fmt::format("{}[{}]", array.path_, index)};
}

std::vector<std::string> Value::keys() const {
  require_object();
  std::vector<std::string> names;
  for (const auto& [name, unused] : json_->items()) names.push_back(name);
  return names;
}

std::string Value::text() const {
  if (!json_->is_string()) fail("should be a string");
  return json_->get<std::string>();
}

bool Value::boolean() const {
  if (!json_->is_boolean()) fail("should be true or false");
  return json_->get<bool>();
}

double Value::number() const {
  if (!json_->is_number()) fail("should be a number");
  const double value = json_->get<double>();
  if (!std::isfinite(value)) fail("should be a finite number");
  return value;
}

std::uint64_t Value::whole() const {
  const double value = number();
  if (value < 0.0 || value > 0x1p53 || value != std::floor(value)) {
    fail(fmt::format("{} is not a whole number from 0 on", value));
  }
  return static_cast<std::uint64_t>(value);
}

std::uint32_t Value::index(std::size_t size, std::string_view what) const {
  const std::uint64_t value = whole();
  if (value >= size || value >= 0xffffffffU) {
    fail(fmt::format("index {} is out of range: the file has {} {}", value, size, what));
  }
  return static_cast<std::uint32_t>(value);
}

std::vector<double> Value::numbers(std::size_t size) const {
  if (!json_->is_array() || json_->size() != size) {
    fail(fmt::format("should be an array of {} numbers", size));
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < size; ++i) {
    values.push_back(Value((*json_)[i], *file_, fmt::format("{}[{}]", path_, i)).number());
  }
  return values;
}

double Value::number_or(const char* key, double fallback) const {
  const std::optional<Value> member = find(key);
  return member ? member->number() : fallback;
}

std::uint64_t Value::whole_or(const char* key, std::uint64_t fallback) const {
  const std::optional<Value> member = find(key);
  return member ? member->whole() : fallback;
}

bool Value::boolean_or(const char* key, bool fallback) const {
  const std::optional<Value> member = find(key);
  return member ? member->boolean() : fallback;
}

std::string Value::text_or(const char* key, const char* fallback) const {
  const std::optional<Value> member = find(key);
  return member ? member->text() : fallback;
}

}  // namespace prt::gltf
