#include "apps/bake/bake.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>

#include "apps/bake/bake_session.h"
#include "apps/bake/command_line.h"
#include "apps/bake/memory.h"
#include "apps/bake/signals.h"
#include "base/log.h"
#include "jobs/mpi/mpi_ranks.h"

namespace prt {

namespace {

/// Once a bake has failed or is done, ranks that do not answer must not hold the others: the
/// orderly end waits for all, and one that dies on the way there never comes. All are idle after a
/// bake that is done, but there may be many.
constexpr std::chrono::seconds kLeaveWithin{10};
constexpr std::chrono::seconds kLeaveDoneWithin{60};

void print_error(const Ranks& ranks, const char* message) {
  if (ranks.rank() != 0) return;
  std::fprintf(stderr, "prt_bake: %s\n", message);
  std::fflush(stderr);
}

ExitCode run(int argc, char** argv, const BakeProgram& program, Ranks& ranks) {
  std::string message;
  const auto command = parse_bake_command(argc, argv, program.methods, message);
  if (!command) {
    if (ranks.rank() == 0) std::fputs(message.c_str(), stdout);
    return ExitCode::kDone;
  }
  log::set_up(command->verbosity, ranks.size() > 1 ? ranks.rank() : -1);
  return bake(*command, program, ranks);
}

}  // namespace

int bake_main(int argc, char** argv, const BakeProgram& program) {
  keep_freed_memory();
  catch_stop_signals();
  const std::unique_ptr<Ranks> ranks = launched_as_rank() ? make_mpi_ranks() : make_single_rank();
  ExitCode code = ExitCode::kFailure;
  try {
    code = run(argc, argv, program, *ranks);
  } catch (const UserError& e) {
    print_error(*ranks, e.what());
    code = ExitCode::kBadInput;
  } catch (const Interrupted&) {
    code = ExitCode::kInterrupted;
  } catch (const RankFailure& e) {
    // Only this rank knows: nobody would tell the others.
    std::fprintf(stderr, "prt_bake: rank %d: %s\n", ranks->rank(), e.what());
    ranks->abort(static_cast<int>(ExitCode::kFailure));
  } catch (const std::exception& e) {
    print_error(*ranks, e.what());
  }
  end_within(code == ExitCode::kDone ? kLeaveDoneWithin : kLeaveWithin, code);
  ranks->finish();
  return static_cast<int>(code);
}

}  // namespace prt
