// prt_inspect: what is in a bake, and whether it is sound.
#include <cstdio>

#include "apps/inspect/inspect.h"
#include "apps/program.h"
#include "base/log.h"

namespace {

prt::ExitCode run(int argc, char** argv) {
  std::string out;
  const auto command = prt::parse_inspect_command(argc, argv, out);
  prt::ExitCode code = prt::ExitCode::kDone;
  try {
    if (command) code = prt::inspect(*command, out);
  } catch (const prt::UnsoundData& e) {
    std::fprintf(stderr, "prt_inspect: %s; run prt_bake again, it makes it anew\n", e.what());
    code = prt::ExitCode::kUnsound;
  }
  std::fputs(out.c_str(), stdout);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  prt::log::set_up(0);
  return prt::run_program("prt_inspect", [&] { return run(argc, argv); });
}
