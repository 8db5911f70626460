// Pictures on disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace prt {

/// Writes 8-bit RGB pixels, top row first, as PNG. The file appears whole or not at all (temporary
/// name in the same folder, then rename). `rgb` holds 3 · width · height values; throws
/// std::logic_error if not, UserError naming the path if the file cannot be written.
void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint8_t> rgb);

}  // namespace prt
