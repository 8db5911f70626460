// prt_inspect: what is in a bake, and whether it is sound.
#include <cstdio>
#include <exception>

#include "apps/inspect/inspect.h"
#include "base/log.h"

namespace {

prt::ExitCode run(int argc, char** argv) {
  std::string out;
  const auto command = prt::parse_inspect_command(argc, argv, out);
  const prt::ExitCode code = command ? prt::inspect(*command, out) : prt::ExitCode::kDone;
  std::fputs(out.c_str(), stdout);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  prt::ExitCode code = prt::ExitCode::kFailure;
  try {
    prt::log::set_up(0);
    code = run(argc, argv);
  } catch (const prt::UserError& e) {
    std::fprintf(stderr, "prt_inspect: %s\n", e.what());
    code = prt::ExitCode::kBadInput;
  } catch (const prt::UnsoundData& e) {
    std::fprintf(stderr, "prt_inspect: %s; run prt_bake again, it makes it anew\n", e.what());
    code = prt::ExitCode::kUnsound;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "prt_inspect: %s\n", e.what());
  }
  return static_cast<int>(code);
}
