// prt_eval: how wrong a package is, and irradiance at points, played or path traced.
#include <cstdio>
#include <exception>

#include "apps/prt_eval_command.h"
#include "apps/prt_eval_error.h"
#include "apps/prt_eval_points.h"
#include "base/error.h"
#include "base/log.h"

namespace {

prt::ExitCode run(int argc, char** argv) {
  std::string message;
  const auto command = prt::parse_eval_command(argc, argv, message);
  if (!command) {
    std::fputs(message.c_str(), stdout);
    return prt::ExitCode::kDone;
  }
  if (command->form == prt::EvalCommand::Form::kError)
    prt::report_package_error(*command);
  else
    prt::evaluate_points(*command);
  return prt::ExitCode::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  prt::ExitCode code = prt::ExitCode::kFailure;
  try {
    prt::log::set_up(0);
    code = run(argc, argv);
  } catch (const prt::UserError& e) {
    std::fprintf(stderr, "prt_eval: %s\n", e.what());
    code = prt::ExitCode::kBadInput;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "prt_eval: %s\n", e.what());
  }
  return static_cast<int>(code);
}
