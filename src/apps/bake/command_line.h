// The command line of prt_bake (design: a contract, scripts depend on it).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/config/config.h"

namespace prt {

struct BakeCommand {
  std::filesystem::path config;
  ConfigOverrides overrides;
  std::filesystem::path trace;  ///< empty: none
  bool plan_only = false;
  bool fresh = false;
  int threads = 0;    ///< 0: this rank's share of the machine
  int verbosity = 0;  ///< -1 quiet, 1 verbose
};

/// Parses; throws UserError. For --help and --version returns nothing and leaves what to print in
/// `message`.
std::optional<BakeCommand> parse_bake_command(int argc, char** argv,
                                              const std::vector<const Method*>& methods,
                                              std::string& message);

}  // namespace prt
