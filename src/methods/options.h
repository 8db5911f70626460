// Options as data: from one table come validation, --help and the manual.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace prt {

/// Points that one option may hold.
inline constexpr std::size_t kMostGivenPoints = 64;

struct OptionSpec {
  enum class Type { kInteger, kNumber, kText, kNumberOrAuto, kIntegerOrAuto, kPointsOrAuto };
  std::string key;  ///< dotted: "lb.visibility_rank"
  Type type = Type::kNumber;
  nlohmann::json fallback;  ///< default value; null: none (unset)
  double minimum = 0.0;     ///< numbers only, inclusive
  double maximum = 0.0;
  std::vector<std::string> choices;  ///< allowed words (kText) or numbers; empty: any
  std::string unit;
  std::string meaning;
  std::string source;  ///< paper and equation or section
  /// What else is wrong with a value that fits (an "auto" included), and what to do; empty:
  /// nothing.
  std::string (*trouble)(const nlohmann::json& value) = nullptr;
};

/// Checked values of all options, by dotted key.
class OptionValues {
 public:
  void set(const std::string& key, nlohmann::json value) { values_[key] = std::move(value); }
  [[nodiscard]] bool is_set(const std::string& key) const;  ///< present and not null
  [[nodiscard]] bool is_auto(const std::string& key) const;
  /// Throws std::logic_error for a key that is in no table: a bug, not a user's error.
  template <typename T>
  [[nodiscard]] T get(const std::string& key) const {
    return at(key).get<T>();
  }
  [[nodiscard]] const nlohmann::json& at(const std::string& key) const;
  [[nodiscard]] const std::map<std::string, nlohmann::json>& all() const { return values_; }

 private:
  std::map<std::string, nlohmann::json> values_;
};

/// What fits the option, in words: "a whole number from 8 to 16", "all or needed".
std::string expected_value(const OptionSpec& spec);

/// Throws UserError unless `value` fits the option; `where` names file and line.
void check_option(const OptionSpec& spec, const nlohmann::json& value, const std::string& where);

/// Options that all methods share: seed, samples.*, rays.*, transport.*, compression.*, accuracy.*,
/// time_limit, evaluate.*, store.*, jobs.*.
std::vector<OptionSpec> shared_options();

/// The values that results may depend on: all but store.*, jobs.* and time_limit, which says only
/// which results are made.
std::map<std::string, nlohmann::json> options_of_results(const OptionValues& options);

}  // namespace prt
