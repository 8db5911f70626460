// Follows a running bake from another process.
#pragma once

#include <cstdio>

#include "store/file_system.h"

namespace prt {

/// Prints how far the bake in `dir` is, whenever that changes, until it is finished: a table that
/// renews itself if `terminal`, else one line each. Only reads. A bake that stands still is told of
/// once and followed on: it may be resumed. Throws UserError if the folder holds no bake.
void watch_bake(FileSystem& fs, const FileSystem::Path& dir, std::FILE* out, bool terminal);

}  // namespace prt
