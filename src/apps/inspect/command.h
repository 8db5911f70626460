// The command line of prt_inspect (design: a contract, scripts depend on it).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace prt {

struct InspectCommand {
  std::filesystem::path bake;
  bool verify = false;
  bool watch = false;
  bool json = false;
  std::string image;  ///< a name of --image; empty: none
  int cluster = 0;
  std::optional<int> index;  ///< sample (depth, default 0) or function (basis, default all)
  std::string environment;   ///< spec that --image environment draws
  std::filesystem::path output;
};

/// Parses; throws UserError. For --help returns nothing and leaves what to print in `message`.
std::optional<InspectCommand> parse_inspect_command(int argc, const char* const* argv,
                                                    std::string& message);

}  // namespace prt
