// Pictures of radiance: Radiance .hdr and OpenEXR. Internal to scene/.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/types.h"

namespace prt {

/// Linear RGB, top row first; finite, negative values taken for 0.
struct RadianceImage {
  int width = 0;
  int height = 0;
  std::vector<Vec3f> pixels;
};

/// Reads a .hdr (RGBE) or an .exr; which it is, the file's own first bytes say. Throws UserError,
/// one line, for anything else, for damaged files and for pictures of more than 2^26 pixels.
RadianceImage read_radiance_image(const std::filesystem::path& file);

/// An OpenEXR file of scan lines with channels R, G, B or Y of half, float or uint, compressed by
/// ZIP, ZIPS or RLE or not at all; others are refused by name. Throws UserError that begins with
/// `name`.
RadianceImage decode_exr(std::span<const unsigned char> bytes, const std::string& name);
bool is_exr(std::span<const unsigned char> bytes);

/// Throws UserError unless a picture of so many pixels can be in a file of so many bytes.
void check_picture_size(std::int64_t width, std::int64_t height, std::size_t file_bytes,
                        const std::string& name);

}  // namespace prt
