// Pictures on disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace prt {

/// Writes 8-bit RGB pixels, top row first, as PNG. The file appears whole or not at all (temporary
/// name in the same folder, then rename). `rgb` holds 3 · width · height values; throws
/// std::logic_error if not, UserError naming the path if the file cannot be written.
void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint8_t> rgb);

/// Writes linear RGB values, top row first, as OpenEXR: 32-bit floats, scan lines, not compressed.
/// As write_png otherwise.
void write_exr(const std::filesystem::path& path, int width, int height,
               std::span<const float> rgb);
/// The bytes of such a file.
std::string encode_exr(int width, int height, std::span<const float> rgb);

/// 8-bit RGB pixels as the bytes of a JPEG file; `quality` in [1, 100].
std::string encode_jpeg(int width, int height, std::span<const std::uint8_t> rgb, int quality);

}  // namespace prt
