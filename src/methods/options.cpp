#include "methods/options.h"

#include <algorithm>
#include <stdexcept>

#include "base/error.h"
#include "domains/directions.h"

namespace prt {

namespace {

using Type = OptionSpec::Type;

std::string number_text(double value) { return nlohmann::json(value).dump(); }

std::string integer_text(double value) { return std::to_string(static_cast<long long>(value)); }

bool allows_auto(Type type) {
  return type == Type::kNumberOrAuto || type == Type::kIntegerOrAuto || type == Type::kPointsOrAuto;
}

bool is_integer_type(Type type) { return type == Type::kInteger || type == Type::kIntegerOrAuto; }

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  }
  return text;
}

bool is_point(const nlohmann::json& value) {
  return value.is_array() && value.size() == 3 &&
         std::ranges::all_of(value, [](const auto& v) { return v.is_number(); });
}

/// One point, or several.
bool are_points(const nlohmann::json& value) {
  return is_point(value) ||
         (value.is_array() && !value.empty() && value.size() <= kMostGivenPoints &&
          std::ranges::all_of(value, is_point));
}

bool fits(const OptionSpec& spec, const nlohmann::json& value) {
  if (allows_auto(spec.type) && value == "auto") return true;
  if (spec.type == Type::kPointsOrAuto) return are_points(value);
  if (!spec.choices.empty()) {
    const std::string word = value.is_string() ? value.get<std::string>() : value.dump();
    return value.is_string() == (spec.type == Type::kText) &&
           std::ranges::find(spec.choices, word) != spec.choices.end();
  }
  if (spec.type == Type::kText) return value.is_string();
  if (is_integer_type(spec.type) ? !value.is_number_integer() : !value.is_number()) return false;
  const double number = value.get<double>();
  return number >= spec.minimum && number <= spec.maximum;
}

std::string directions_trouble(const nlohmann::json& value) {
  const int count = value.get<int>();
  const int near = HemisphereDirections::nearest_count(count);
  if (near == count) return "";
  return std::to_string(count) + " directions form no grid of two like sides; use " +
         std::to_string(near);
}

}  // namespace

std::string expected_value(const OptionSpec& spec) {
  std::string text;
  if (spec.type == Type::kPointsOrAuto) {
    text = "points [[x, y, z], ...], a point [x, y, z]";
  } else if (!spec.choices.empty()) {
    return joined(spec.choices);
  } else if (spec.type == Type::kText) {
    return "a word";
  } else if (is_integer_type(spec.type)) {
    text =
        "a whole number from " + integer_text(spec.minimum) + " to " + integer_text(spec.maximum);
  } else {
    text = "a number from " + number_text(spec.minimum) + " to " + number_text(spec.maximum);
  }
  return allows_auto(spec.type) ? text + " or auto" : text;
}

void check_option(const OptionSpec& spec, const nlohmann::json& value, const std::string& where) {
  if (fits(spec, value)) {
    const std::string trouble = spec.trouble != nullptr ? spec.trouble(value) : "";
    if (!trouble.empty()) throw UserError(where + ": " + spec.key + ": " + trouble);
    return;
  }
  throw UserError(where + ": " + spec.key + " must be " + expected_value(spec) + ", not " +
                  (value.is_null()
                       ? "empty"
                       : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
}

bool OptionValues::is_set(const std::string& key) const { return !at(key).is_null(); }

bool OptionValues::is_auto(const std::string& key) const { return at(key) == "auto"; }

const nlohmann::json& OptionValues::at(const std::string& key) const {
  const auto it = values_.find(key);
  if (it == values_.end()) throw std::logic_error("option " + key + " is in no table");
  return it->second;
}

std::vector<OptionSpec> shared_options() {
  constexpr double kMostSeed = 9007199254740992.0;  // 2^53: exact as a JSON number
  const std::string lb = "Leonhardt & Bohn ";
  return {
      {"seed", Type::kInteger, 1, 0, kMostSeed, {}, "", "seed of all random numbers", "ours"},
      {"samples.count",
       Type::kInteger,
       45000,
       50,
       10'000'000,
       {},
       "samples",
       "number of sample points, met within 5 %",
       lb + "§4.1, §5"},
      {"samples.spacing",
       Type::kNumber,
       nullptr,
       1e-6,
       1e6,
       {},
       "m",
       "Poisson-disk radius, instead of samples.count",
       lb + "§4.1"},
      {"samples.cluster_size",
       Type::kInteger,
       1000,
       8,
       100'000,
       {},
       "samples",
       "mean number of samples in a cluster",
       lb + "§4.1"},
      {"samples.start",
       Type::kPointsOrAuto,
       "auto",
       0,
       0,
       {},
       "m",
       "point inside the scene, in the file's world, where sampling starts, or one in each of its "
       "sealed rooms; auto: the scene's camera, else searched for",
       lb + "§4.1"},
      {"rays.directions",
       Type::kInteger,
       1008,
       35,
       32767,
       {},
       "",
       "hemispherical directions per sample",
       lb + "§4.2",
       directions_trouble},
      {"transport.tolerance",
       Type::kNumber,
       2e-2,
       1e-9,
       1.0,
       {},
       "1",
       "relative residual of the indirect light, and share of it that may be left out",
       "ours"},
      {"transport.bounces",
       Type::kIntegerOrAuto,
       "auto",
       0,
       1000,
       {},
       "",
       "most bounces; auto: until at most transport.tolerance of the indirect light is missing",
       lb + "§4.3.2"},
      {"compression.tolerance",
       Type::kNumber,
       1e-2,
       1e-6,
       1.0,
       {},
       "1",
       "relative error that compressing the transfer may add",
       lb + "§4.4"},
      {"compression.bits",
       Type::kInteger,
       8,
       8,
       16,
       {"8", "16"},
       "bit",
       "size of the integers in the package",
       lb + "§4.4"},
      {"accuracy.indirect",
       Type::kNumber,
       nullptr,
       1e-3,
       10.0,
       {},
       "1",
       "relative RMS error of indirect light to reach: samples, directions, ranks and tolerances "
       "are "
       "then chosen by the bake, step by step, from the error it measures",
       "ours"},
      {"accuracy.visibility",
       Type::kNumber,
       nullptr,
       1e-3,
       1.0,
       {},
       "1",
       "share of wrongly judged shadows to reach, likewise",
       "ours"},
      {"time_limit",
       Type::kNumber,
       nullptr,
       0.1,
       1e8,
       {},
       "s",
       "wall time of the whole bake: samples, directions, ranks and tolerances are then chosen by "
       "the bake, as fine as it expects to make in that time on the ranks it has; with accuracy.*, "
       "whichever is met first",
       "ours"},
      {"evaluate.lights",
       Type::kInteger,
       8,
       0,
       1000,
       {},
       "lights",
       "test lights by which the bake measures its own error; 0: it does not",
       "ours"},
      {"evaluate.points",
       Type::kInteger,
       1000,
       0,
       10'000'000,
       {},
       "",
       "points per light, at samples (direct light: at all of them) and on the surface",
       "ours"},
      {"evaluate.spp",
       Type::kInteger,
       64,
       1,
       1'000'000,
       {},
       "",
       "paths per point and light of the reference",
       "ours"},
      {"store.keep",
       Type::kText,
       "all",
       0,
       0,
       {"all", "needed"},
       "",
       "needed: an artifact goes once all that read it are done",
       "ours"},
      {"jobs.lease",
       Type::kNumber,
       30.0,
       0.5,
       86'400.0,
       {},
       "s",
       "a rank that is silent for longer is taken for lost, and its tasks go to others",
       "ours"},
      {"jobs.grace",
       Type::kNumber,
       30.0,
       0.0,
       86'400.0,
       {},
       "s",
       "after SIGUSR1 running tasks may take so long to end",
       "ours"},
  };
}

std::map<std::string, nlohmann::json> options_of_results(const OptionValues& options) {
  std::map<std::string, nlohmann::json> values = options.all();
  std::erase_if(values, [](const auto& value) {
    return value.first.starts_with("store.") || value.first.starts_with("jobs.") ||
           value.first == "time_limit";
  });
  return values;
}

}  // namespace prt
