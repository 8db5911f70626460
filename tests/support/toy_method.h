// A toy method and a scene of one triangle: the whole bake service with tasks of a few
// milliseconds.
//
// Three stages: `leaf` tasks draw numbers, `pair` tasks add two leaves, and, planned only from what
// the first stage made, `total` adds everything up. The environment steers faults from outside the
// results:
//   PRT_TOY_SPIN_US   every task computes for so long (its result is the same)
//   PRT_TOY_SLOW_SYNC_MS   every sync of the manifest takes so much longer
//   PRT_TOY_FAIL      id of a task that fails; PRT_TOY_FAIL_KIND user|memory|bug
#pragma once

#include <functional>
#include <string>

#include "apps/bake/bake.h"

namespace prt::test {

BakeProgram toy_program();

/// The same with three levels of effort: 10, 20 and 40 leaves, with nothing in common.
/// `before_task` is called with the id of each task that is made, and may throw.
BakeProgram toy_program_with_levels(std::function<void(const std::string& task)> before_task);

}  // namespace prt::test
