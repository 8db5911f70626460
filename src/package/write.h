// Writes a package as a glTF binary with the root extension PRT_light_transfer.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "package/package.h"

namespace prt {

/// The whole .glb file. Equal packages give equal bytes.
std::vector<std::byte> encode_package(const Package& package);

/// Writes it under a temporary name, fsyncs and renames. Throws UserError if the folder is not
/// writable.
void write_package(const Package& package, const std::filesystem::path& file);

}  // namespace prt
