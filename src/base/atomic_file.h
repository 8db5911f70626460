// Files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace prt {

/// Writes bytes under a temporary name in the same folder, syncs, renames, and syncs the folder: at
/// no instant does `path` name a part of the file. Throws UserError naming the path if the file
/// cannot be written; nothing is left behind then.
void write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace prt
