#include "apps/bake/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "apps/program.h"
#include "base/error.h"

namespace prt {

std::optional<BakeCommand> parse_bake_command(int argc, char** argv,
                                              const std::vector<const Method*>& methods,
                                              std::string& message) {
  constexpr int kMostThreads = 4096;
  BakeCommand command;
  std::string config, out, trace;
  bool verbose = false;
  bool quiet = false;
  CLI::App app{
      "Bakes precomputed light transport for a static scene. Run it again after an interruption "
      "and "
      "it goes on; on a finished bake it verifies.",
      "prt_bake"};
  app.add_option("CONFIG", config, "configuration (YAML)")->required();
  app.add_option("--set", command.overrides.settings,
                 "override a configuration key: key.path=value")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("KEY=VALUE");
  app.add_option("--out", out, "folder of the bake, instead of the configured output")
      ->type_name("DIR");
  app.add_flag("--plan", command.plan_only,
               "print what would be made and what is left out; make nothing");
  app.add_flag("--fresh", command.fresh, "forget what is in the folder and bake anew");
  app.add_option("--threads", command.threads,
                 "threads per rank (default: its share of the machine)")
      ->check(CLI::Range(1, kMostThreads))
      ->type_name("N");
  app.add_option("--trace", trace, "write when which thread ran what (Chrome trace)")
      ->type_name("FILE.json");
  auto* v = app.add_flag("-v,--verbose", verbose, "say more");
  app.add_flag("-q,--quiet", quiet, "warnings and errors only")->excludes(v);
  app.footer(
      "Exit codes: 0 done, 2 bad command line, configuration or input, 3 interrupted (run it "
      "again to go on), 1 anything else.\n\n" +
      describe_options(methods));
  if (!parse_arguments(app, argc, argv, message)) return std::nullopt;
  command.config = config;
  command.overrides.output = out;
  command.trace = trace;
  command.verbosity = verbose ? 1 : quiet ? -1 : 0;
  return command;
}

}  // namespace prt
