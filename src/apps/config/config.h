// A bake's configuration: a YAML file plus what the command line overrides, checked against the
// option tables of the methods.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "methods/method.h"

namespace prt {

struct BakeConfig {
  std::filesystem::path scene;           ///< absolute
  std::filesystem::path output;          ///< absolute
  std::shared_ptr<const Method> method;  ///< several: methods/combined.h
  OptionValues options;                  ///< every shared option and every option of the method
};

/// What the command line adds to the file.
struct ConfigOverrides {
  std::vector<std::string> settings;  ///< "key.path=value", later ones win
  std::filesystem::path output;       ///< empty: as configured
};

/// Reads and checks. Paths in the file are relative to the file, those of the overrides to the
/// working directory; without an output it is out/<stem of the scene> there. Throws UserError with
/// one line that names file, line and key: missing, empty or huge file, no map, syntax, unknown key
/// (with the nearest known one), duplicate key, wrong type, out of range, both samples.count and
/// samples.spacing.
BakeConfig load_config(const std::filesystem::path& file, const ConfigOverrides& overrides,
                       const std::vector<const Method*>& methods);

/// The table of all keys with unit, default, range and source, for --help.
std::string describe_options(const std::vector<const Method*>& methods);

/// Edits (insert, delete, replace, swap neighbours) that turn one word into the other.
std::size_t edit_distance(const std::string& a, const std::string& b);

}  // namespace prt
