// prt_eval: how wrong a package is, and irradiance at points, played or path traced.
#include <cstdio>

#include "apps/program.h"
#include "apps/prt_eval_command.h"
#include "apps/prt_eval_error.h"
#include "apps/prt_eval_points.h"
#include "apps/prt_eval_sky.h"
#include "base/log.h"

namespace {

prt::ExitCode run(int argc, char** argv) {
  std::string message;
  const auto command = prt::parse_eval_command(argc, argv, message);
  if (!command) {
    std::fputs(message.c_str(), stdout);
    return prt::ExitCode::kDone;
  }
  using Form = prt::EvalCommand::Form;
  if (command->form == Form::kError) {
    prt::report_package_error(*command);
  } else if (command->form == Form::kSkyError) {
    prt::report_sky_error(*command);
  } else {
    prt::evaluate_points(*command);
  }
  return prt::ExitCode::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  prt::log::set_up(0);
  return prt::run_program("prt_eval", [&] { return run(argc, argv); });
}
