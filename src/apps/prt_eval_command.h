// The command line of prt_eval (design: a contract, scripts depend on it).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/light.h"

namespace prt {

struct EvalCommand {
  enum class Form {
    kError,       ///< a package's error against the reference
    kSkyError,    ///< the same under environments
    kPlayPoints,  ///< irradiance at points, as the player has it
    kTracePoints  ///< irradiance at points, path traced
  } form = Form::kError;
  std::filesystem::path input;  ///< package, or scene for kTracePoints
  std::size_t lights = 8;       ///< test lights, kError
  std::uint64_t seed = 1;
  int paths = 64;                  ///< per point and light
  std::optional<float> clearance;  ///< m, kError
  std::filesystem::path json;      ///< kError; empty: print a table
  std::filesystem::path pictures;  ///< kError; folder for an error picture per light; empty: none
  std::filesystem::path points;    ///< CSV in
  std::vector<WorldLight> point_lights;
  std::vector<std::string> environments;  ///< specs; one at most for points
  std::filesystem::path output;           ///< CSV out
};

/// Parses; throws UserError. For --help returns nothing and leaves the text in `message`.
std::optional<EvalCommand> parse_eval_command(int argc, char** argv, std::string& message);

}  // namespace prt
