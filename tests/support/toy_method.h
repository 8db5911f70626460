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

#include "apps/bake/bake.h"

namespace prt::test {

BakeProgram toy_program();

}  // namespace prt::test
