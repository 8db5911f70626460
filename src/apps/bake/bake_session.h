// One bake from configuration to package, on every rank of the job.
#pragma once

#include <stdexcept>

#include "apps/bake/bake.h"
#include "apps/bake/command_line.h"
#include "jobs/ranks.h"

namespace prt {

/// A failure on one rank that the others know nothing of.
class RankFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Collective. What goes wrong before work begins is agreed on: every rank then throws the same
/// UserError. Messages of later failures are printed by rank 0, and the code says the rest.
ExitCode bake(const BakeCommand& command, const BakeProgram& program, Ranks& ranks);

}  // namespace prt
