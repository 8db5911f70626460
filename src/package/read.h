// Reads and validates a package: any file that gets through can be played.
#pragma once

#include <filesystem>

#include "package/package.h"

namespace prt {

/// Throws UserError (one line: file, what is wrong, what to do) for anything that is not a sound
/// package.
Package read_package(const std::filesystem::path& file);

}  // namespace prt
