// The first half of reading a configuration: YAML text into a flat list of dotted keys.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>
#include <vector>

namespace prt {

/// One leaf: "lb.visibility_rank", its value, and where it stands ("configs/a.yaml:12").
struct ConfigEntry {
  std::string key;
  YAML::Node value;
  std::string where;
};

/// Every leaf of a YAML file, in order. `sections` are the names that hold further keys. Throws
/// UserError: unreadable, empty or huge file, syntax error, not a map, duplicate key.
std::vector<ConfigEntry> read_config_entries(const std::filesystem::path& file,
                                             const std::vector<std::string>& sections);

/// "key.path=value" from the command line.
ConfigEntry parse_setting(const std::string& setting);

}  // namespace prt
