#include "apps/inspect/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "apps/program.h"
#include "base/error.h"
#include "scene/environment.h"

namespace prt {

namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw UserError("command line: " + why + "; prt_inspect --help shows the options");
}

/// Options that have no use in this combination are refused rather than ignored.
void check_combination(const CLI::App& app, const InspectCommand& command) {
  if (command.watch && (command.verify || command.json || !command.image.empty())) {
    refuse("--watch goes with no other option");
  }
  if (command.image.empty()) {
    for (const char* option : {"--cluster", "--index", "--env", "--output"}) {
      if (app.count(option) > 0) refuse(std::string(option) + " needs --image KIND");
    }
    return;
  }
  if (command.output.empty()) refuse("--image needs -o FILE.png");
  if (command.verify || command.json) refuse("--image goes neither with --verify nor with --json");
  if (command.image == "curves" && command.output.extension() != ".svg") {
    refuse("--image curves draws SVG: it needs -o FILE.svg");
  }
  const bool draws_environment = command.image == "environment";
  if (draws_environment != (app.count("--env") > 0)) {
    refuse(draws_environment ? "--image environment needs --env SPEC"
                             : "--env goes with --image environment only");
  }
  const bool of_cluster = command.image == "depth" || command.image == "basis";
  if (app.count("--cluster") > 0 && !of_cluster) {
    refuse("--cluster goes with --image depth and basis only");
  }
  if (app.count("--index") > 0 && !of_cluster && command.image != "sky") {
    refuse("--index goes with --image depth, basis and sky only");
  }
}

}  // namespace

std::optional<InspectCommand> parse_inspect_command(int argc, const char* const* argv,
                                                    std::string& message) {
  InspectCommand command;
  CLI::App app{"Shows what is in a bake, and whether it is sound.", "prt_inspect"};
  app.add_option("BAKE_DIR", command.bake, "folder that prt_bake wrote to")->required();
  app.add_flag("--verify", command.verify,
               "read every artifact again; exit code 4 if one is unsound");
  app.add_flag("--watch", command.watch, "follow a running bake until it is finished");
  app.add_flag("--json", command.json, "tables as JSON");
  app.add_option(
         "--image", command.image,
         "draw a picture: clusters (samples coloured by cluster), rank (light functions per "
         "cluster), "
         "error (of each cluster's transfer), depth (a sample's depth buffer beside its "
         "reconstruction), basis (a cluster's light functions), curves (what hangs on each basis "
         "function, by cluster; SVG), sky (transfer of each spherical harmonic of the sky) or "
         "environment (one beside its spherical harmonics, and their energy by band)")
      ->check(CLI::IsMember(
          {"clusters", "rank", "error", "depth", "basis", "curves", "sky", "environment"}))
      ->type_name("KIND");
  app.add_option("--cluster", command.cluster, "cluster that depth and basis show")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  app.add_option("--index", command.index,
                 "depth: sample within the cluster; basis, sky: this function alone")
      ->check(CLI::NonNegativeNumber)
      ->type_name("K");
  app.add_option("--env", command.environment,
                 std::string("environment to draw: ") + kEnvironmentForms)
      ->type_name("SPEC");
  app.add_option("-o,--output", command.output, "picture to write")->type_name("FILE");
  app.footer(
      "Exit codes: 0 done, 2 bad command line or no bake, 4 verification failed, 1 anything else.");
  if (!parse_arguments(app, argc, argv, message)) return std::nullopt;
  check_combination(app, command);
  return command;
}

}  // namespace prt
