// How the process keeps its memory.
#pragma once

namespace prt {

/// From now on freed memory stays with the process and is used again. Tasks allocate and free
/// arrays of many megabytes; returning each to the kernel and having it zeroed anew costs a fifth
/// of a bake (results/service.md). Call it once, before threads start.
void keep_freed_memory();

/// Returns to the kernel what is free after all.
void return_freed_memory();

}  // namespace prt
