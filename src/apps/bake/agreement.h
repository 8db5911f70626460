// Steps at start-up that each rank does by itself and that must end alike on all.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "jobs/ranks.h"

namespace prt {

/// Runs `step` on every rank. If it throws on any, all ranks throw what the lowest of those threw,
/// as UserError if it was one. Collective.
void do_together(Ranks& ranks, const std::function<void()>& step);

/// Throws UserError on every rank unless all hand in the same text. `what` completes "the ranks
/// see".
void expect_same(Ranks& ranks, const std::string& text, const std::string& what);

/// The lowest of the instruction sets that the ranks can run.
std::string lowest_isa(const std::vector<std::string>& isas);

/// Whether a machine whose best is `best` can run `isa`.
bool can_run(const std::string& best, const std::string& isa);

}  // namespace prt
