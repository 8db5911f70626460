#include "apps/config/config_entries.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>

#include "base/error.h"

namespace prt {

namespace {

/// A configuration is a page of text; more is some other file.
constexpr std::uintmax_t kMostBytes = 1 << 20;

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string read_text(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    throw UserError(name + ": there is no such configuration file");
  if (!std::filesystem::is_regular_file(status))
    throw UserError(name + ": is a folder or a device, not a file");
  if (std::filesystem::file_size(file, error) > kMostBytes) {
    throw UserError(name + ": is larger than 1 MiB, so it is no configuration");
  }
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw UserError(name + ": cannot be read; check its permissions");
  if (text.find('\0') != std::string::npos) throw UserError(name + ": is not a text file");
  return text;
}

YAML::Node parse_document(const std::string& text, const std::string& name) {
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(text);
  } catch (const YAML::Exception& e) {
    const std::string line = e.mark.is_null() ? "" : ":" + std::to_string(e.mark.line + 1);
    throw UserError(name + line + ": is not valid YAML: " + one_line(e.msg));
  }
  if (documents.empty() || documents[0].IsNull()) {
    throw UserError(name + ": is empty; it needs at least a line 'scene: FILE.glb'");
  }
  if (documents.size() > 1) throw UserError(name + ": holds several YAML documents; keep one");
  if (!documents[0].IsMap()) {
    throw UserError(name + ":1: must be a list of keys and values such as 'scene: FILE.glb'");
  }
  return documents[0];
}

class Flattener {
 public:
  Flattener(std::string file, const std::vector<std::string>& sections)
      : file_(std::move(file)), sections_(sections) {}

  void flatten(const YAML::Node& map, const std::string& prefix) {
    for (const auto& pair : map) {
      const std::string where = file_ + ":" + std::to_string(pair.first.Mark().line + 1);
      if (!pair.first.IsScalar()) throw UserError(where + ": a key must be a single word");
      const std::string key = prefix + pair.first.Scalar();
      const auto [seen, is_new] = lines_.emplace(key, pair.first.Mark().line + 1);
      if (!is_new) {
        throw UserError(fmt::format("{}: duplicate key \"{}\", first on line {}; remove one", where,
                                    key, seen->second));
      }
      add(key, pair.second, where, prefix.empty());
    }
  }

  std::vector<ConfigEntry> entries;

 private:
  void add(const std::string& key, const YAML::Node& value, const std::string& where, bool top) {
    if (!top || std::ranges::find(sections_, key) == sections_.end()) {
      entries.push_back({key, value, where});
    } else if (value.IsMap()) {
      flatten(value, key + ".");
    } else if (!value.IsNull()) {
      throw UserError(where + ": \"" + key + "\" must hold keys of its own, such as {key: value}");
    }
  }

  std::string file_;
  const std::vector<std::string>& sections_;
  std::map<std::string, int> lines_;
};

}  // namespace

std::vector<ConfigEntry> read_config_entries(const std::filesystem::path& file,
                                             const std::vector<std::string>& sections) {
  const std::string name = file.string();
  const YAML::Node document = parse_document(read_text(file), name);
  Flattener flattener(name, sections);
  flattener.flatten(document, "");
  return std::move(flattener.entries);
}

ConfigEntry parse_setting(const std::string& setting) {
  const std::string where = "--set " + setting;
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw UserError(where + ": must look like key.path=value");
  }
  const std::string key = setting.substr(0, equals);
  const std::string text = setting.substr(equals + 1);
  if (key == "scene" || key == "output") return {key, YAML::Node(text), where};
  try {
    return {key, YAML::Load(text), where};
  } catch (const YAML::Exception& e) {
    throw UserError(where + ": the value is not valid YAML: " + one_line(e.msg));
  }
}

}  // namespace prt
