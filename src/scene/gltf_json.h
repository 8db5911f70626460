// Checked reading of glTF's JSON: every access says what it expects, and a file that breaks the
// rule ends in a UserError that names the file and the key. Internal to scene/.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace prt::gltf {

/// "scene FILE: WHAT", in one line of printable characters.
[[noreturn]] void fail(const std::string& file, std::string_view what);

/// A JSON value, and where it stands in which file. Refers to both; copy it freely.
class Value {
 public:
  Value(const nlohmann::json& json, const std::string& file, std::string path)
      : json_(&json), file_(&file), path_(std::move(path)) {}

  /// The value as it is, for data that is only handed on.
  [[nodiscard]] const nlohmann::json& json() const { return *json_; }

  /// UserError that names this value.
  [[noreturn]] void fail(std::string_view what) const;

  /// Member of an object; find() is empty where there is none, operator[] is then an error.
  [[nodiscard]] std::optional<Value> find(const char* key) const;
  [[nodiscard]] Value operator[](const char* key) const;
  /// Elements of an array member; none where the member is missing.
  [[nodiscard]] std::vector<Value> list(const char* key) const;
  /// Number of elements of an array member; 0 where the member is missing.
  [[nodiscard]] std::size_t count_of(const char* key) const;
  /// Element of an array member, by an index that was checked before.
  [[nodiscard]] Value element(const char* key, std::size_t index) const;
  /// Names of an object's members.
  [[nodiscard]] std::vector<std::string> keys() const;

  [[nodiscard]] std::string text() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] double number() const;
  /// A whole number in [0, 2^53].
  [[nodiscard]] std::uint64_t whole() const;
  /// A whole number below `size`, the number of `what` there are.
  [[nodiscard]] std::uint32_t index(std::size_t size, std::string_view what) const;
  /// An array of exactly `size` numbers.
  [[nodiscard]] std::vector<double> numbers(std::size_t size) const;

  /// Members with defaults.
  [[nodiscard]] double number_or(const char* key, double fallback) const;
  [[nodiscard]] std::uint64_t whole_or(const char* key, std::uint64_t fallback) const;
  [[nodiscard]] bool boolean_or(const char* key, bool fallback) const;
  [[nodiscard]] std::string text_or(const char* key, const char* fallback) const;

 private:
  void require_object() const;

  const nlohmann::json* json_;
  const std::string* file_;
  std::string path_;
};

}  // namespace prt::gltf
