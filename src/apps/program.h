// What the four programs share: their end, and how they read a command line.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "base/error.h"

namespace prt {

/// Runs a program's body and turns what it throws into one line on stderr and an exit code.
template <typename Body>
int run_program(const char* name, Body&& body) {
  ExitCode code = ExitCode::kFailure;
  try {
    code = body();
  } catch (const UserError& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    code = ExitCode::kBadInput;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
  }
  return static_cast<int>(code);
}

/// For options that are numbers: CLI11's ranges let nan through.
inline CLI::Validator finite_number() {
  return CLI::Validator(
      [](const std::string& text) {
        return std::isfinite(std::strtod(text.c_str(), nullptr)) ? std::string()
                                                                 : text + " is not a finite number";
      },
      "");
}

/// Adds --version and parses. False after --help or --version: `message` is then what to print.
/// Throws UserError, one line, for a command line that does not fit.
inline bool parse_arguments(CLI::App& app, int argc, const char* const* argv,
                            std::string& message) {
  app.set_version_flag("--version", app.get_name() + " " + PRT_VERSION);
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::CallForHelp&) {
    message = app.help();
  } catch (const CLI::CallForVersion&) {
    message = app.version() + "\n";
  } catch (const CLI::ParseError& e) {
    std::string why = e.what();
    std::ranges::replace(why, '\n', ' ');
    throw UserError("command line: " + why + "; " + app.get_name() + " --help lists all options");
  }
  return false;
}

}  // namespace prt
