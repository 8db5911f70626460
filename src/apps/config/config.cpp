#include "apps/config/config.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>

#include "apps/config/config_entries.h"
#include "base/error.h"
#include "methods/combined.h"

namespace prt {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Type = OptionSpec::Type;

/// All keys there are: of every registered method, so that one file can serve several.
struct KeyTable {
  explicit KeyTable(const std::vector<const Method*>& methods) {
    for (const OptionSpec& spec : shared_options()) add(spec);
    for (const Method* method : methods) {
      for (const OptionSpec& spec : method->options()) add(spec);
    }
  }

  void add(const OptionSpec& spec) {
    specs.emplace(spec.key, spec);
    names.insert(spec.key);
    const std::size_t dot = spec.key.find('.');
    if (dot != std::string::npos) sections.insert(spec.key.substr(0, dot));
  }

  std::map<std::string, OptionSpec> specs;
  std::set<std::string> names{"scene", "output", "methods"};
  std::set<std::string> sections;
};

[[noreturn]] void unknown_key(const ConfigEntry& entry, const KeyTable& table) {
  std::string text = entry.where + ": unknown key \"" + entry.key + "\"";
  if (table.sections.contains(entry.key)) {
    throw UserError(entry.where + ": \"" + entry.key + "\" is a section; name a key in it");
  }
  std::vector<std::string> candidates(table.names.begin(), table.names.end());
  candidates.insert(candidates.end(), table.sections.begin(), table.sections.end());
  const auto nearest = std::ranges::min_element(
      candidates, {}, [&](const std::string& name) { return edit_distance(entry.key, name); });
  throw UserError(text + "; the nearest known key is \"" + *nearest + "\"");
}

/// A plain (unquoted) scalar as a JSON number, if it is one.
std::optional<json> as_number(const YAML::Node& node) {
  if (!node.IsScalar() || node.Tag() == "!") return std::nullopt;
  std::string text = node.Scalar();
  if (!text.empty() && text[0] == '+') text.erase(0, 1);
  const char* end = text.data() + text.size();
  std::int64_t integer = 0;
  if (const auto [stop, error] = std::from_chars(text.data(), end, integer);
      error == std::errc() && stop == end) {
    return integer;
  }
  double number = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

/// A list of numbers or of points, cut where it is too long to be either.
json list_of(const YAML::Node& node) {
  constexpr std::size_t kMostNumbers = 4;
  const bool lists = node.size() > 0 && node[0].IsSequence();
  json list = json::array();
  for (std::size_t i = 0; i < std::min(node.size(), lists ? kMostGivenPoints + 1 : kMostNumbers);
       ++i) {
    if (lists && node[i].IsSequence() && !(node[i].size() > 0 && node[i][0].IsSequence())) {
      list.push_back(list_of(node[i]));
      continue;
    }
    const auto number = as_number(node[i]);
    list.push_back(number ? json(number->get<double>()) : json("?"));
  }
  return list;
}

/// The value as JSON, of the option's own number type where it fits; check_option judges it then.
json to_json(const OptionSpec& spec, const YAML::Node& node) {
  if (node.IsSequence()) return list_of(node);
  if (node.IsMap()) return json("a section");
  if (node.IsNull()) return nullptr;
  if (spec.type == Type::kText) return node.Scalar();
  const auto number = as_number(node);
  if (!number) return node.Scalar();
  const bool real = spec.type == Type::kNumber || spec.type == Type::kNumberOrAuto;
  return real ? json(number->get<double>()) : *number;
}

class Reader {
 public:
  Reader(const std::vector<const Method*>& methods) : methods_(methods), table_(methods) {}

  void read_file(const fs::path& file) {
    const std::vector<std::string> sections(table_.sections.begin(), table_.sections.end());
    std::set<std::string> given;
    for (const ConfigEntry& entry : read_config_entries(file, sections)) {
      apply(entry, fs::absolute(file).parent_path());
      given.insert(entry.key);
    }
    settle_sampling(given, file.string());
  }

  void read_settings(const std::vector<std::string>& settings) {
    std::set<std::string> given;
    for (const std::string& setting : settings) {
      const ConfigEntry entry = parse_setting(setting);
      apply(entry, fs::current_path());
      given.insert(entry.key);
    }
    settle_sampling(given, "--set");
  }

  BakeConfig finish(const fs::path& file, const fs::path& output) {
    BakeConfig config;
    if (scene_.empty()) {
      throw UserError(file.string() + ": key \"scene\" is missing; add 'scene: FILE.glb'");
    }
    config.scene = scene_;
    config.output = !output.empty()    ? fs::absolute(output)
                    : !output_.empty() ? output_
                                       : fs::absolute(fs::path("out") / scene_.stem());
    config.output = without_trailing_slash(config.output.lexically_normal());
    config.method = combined(chosen_.empty() ? std::vector{default_method(file)} : chosen_);
    for (const OptionSpec& spec : shared_options()) take(spec, config.options);
    for (const OptionSpec& spec : config.method->options()) take(spec, config.options);
    return config;
  }

 private:
  static fs::path without_trailing_slash(const fs::path& path) {
    return path.has_filename() ? path : path.parent_path();
  }

  const Method* default_method(const fs::path& file) const {
    if (methods_.empty()) throw UserError(file.string() + ": this build has no method");
    return methods_.front();
  }

  void take(const OptionSpec& spec, OptionValues& options) const {
    const auto it = values_.find(spec.key);
    options.set(spec.key, it == values_.end() ? spec.fallback : it->second);
  }

  void apply(const ConfigEntry& entry, const fs::path& base) {
    if (entry.key == "scene") {
      scene_ = path_of(entry, base);
    } else if (entry.key == "output") {
      output_ = path_of(entry, base);
    } else if (entry.key == "methods") {
      chosen_ = methods_of(entry);
    } else {
      const auto spec = table_.specs.find(entry.key);
      if (spec == table_.specs.end()) unknown_key(entry, table_);
      const json value = to_json(spec->second, entry.value);
      check_option(spec->second, value, entry.where);
      values_[entry.key] = value;
    }
  }

  static fs::path path_of(const ConfigEntry& entry, const fs::path& base) {
    if (!entry.value.IsScalar() || entry.value.Scalar().empty()) {
      throw UserError(entry.where + ": " + entry.key + " must be a path");
    }
    return (base / entry.value.Scalar()).lexically_normal();
  }

  /// In the order of the registry, whatever the order of the list: it changes no result.
  std::vector<const Method*> methods_of(const ConfigEntry& entry) const {
    std::set<std::string> wanted;
    bool sound = entry.value.IsScalar() || (entry.value.IsSequence() && entry.value.size() > 0);
    const auto want = [&](const YAML::Node& word) {
      sound = sound && word.IsScalar() && wanted.insert(word.Scalar()).second;
    };
    if (entry.value.IsScalar()) want(entry.value);
    for (std::size_t i = 0; entry.value.IsSequence() && i < entry.value.size(); ++i) {
      want(entry.value[i]);
    }
    std::vector<const Method*> chosen;
    std::string names;
    for (const Method* method : methods_) {
      names += " " + method->name();
      if (wanted.contains(method->name())) chosen.push_back(method);
    }
    if (sound && chosen.size() == wanted.size()) return chosen;
    throw UserError(entry.where +
                    ": methods must be a list, each once, with at least one of:" + names);
  }

  /// samples.count and samples.spacing stand for each other: the later source wins, one source must
  /// not give both.
  void settle_sampling(const std::set<std::string>& given, const std::string& where) {
    const bool count = given.contains("samples.count");
    const bool spacing = given.contains("samples.spacing");
    if (count && spacing) {
      throw UserError(where + ": samples.count and samples.spacing exclude each other; give one");
    }
    if (count) values_["samples.spacing"] = nullptr;
    if (spacing) values_["samples.count"] = nullptr;
  }

  const std::vector<const Method*>& methods_;
  KeyTable table_;
  std::map<std::string, json> values_;
  fs::path scene_;
  fs::path output_;
  std::vector<const Method*> chosen_;  // empty: the default
};

}  // namespace

std::size_t edit_distance(const std::string& a, const std::string& b) {
  // Rows of the optimal string alignment table: two back, last, current.
  std::vector<std::size_t> before;
  std::vector<std::size_t> last(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::vector<std::size_t> row(b.size() + 1, i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = std::exchange(last, std::move(row));
  }
  return last[b.size()];
}

BakeConfig load_config(const fs::path& file, const ConfigOverrides& overrides,
                       const std::vector<const Method*>& methods) {
  Reader reader(methods);
  reader.read_file(file);
  reader.read_settings(overrides.settings);
  return reader.finish(file, overrides.output);
}

std::string describe_options(const std::vector<const Method*>& methods) {
  std::ostringstream out;
  const auto describe = [&](const OptionSpec& spec) {
    const json& fallback = spec.fallback;
    const std::string value = fallback.is_null()     ? "none"
                              : fallback.is_string() ? fallback.get<std::string>()
                                                     : fallback.dump();
    out << "  " << spec.key;
    if (!spec.unit.empty() && spec.unit != "1") out << " [" << spec.unit << "]";
    out << "\n      " << spec.meaning << "\n      default " << value << "; " << expected_value(spec)
        << "; source: " << spec.source << "\n";
  };
  out << "Configuration keys (in the file, or --set KEY=VALUE):\n"
         "  scene\n      glTF 2.0 scene, .glb or .gltf; required\n"
         "  output\n      folder of the bake; default out/<scene>\n"
         "  methods\n      list with one or more of:";
  for (const Method* method : methods) out << " " << method->name();
  out << "\n";
  for (const OptionSpec& spec : shared_options()) describe(spec);
  for (const Method* method : methods) {
    for (const OptionSpec& spec : method->options()) describe(spec);
  }
  return out.str();
}

}  // namespace prt
