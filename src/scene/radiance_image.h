// Pictures of radiance: Radiance .hdr and OpenEXR. Internal to scene/.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/types.h"

namespace prt {

/// Linear RGB, top row first.
struct RadianceImage {
  int width = 0;
  int height = 0;
  std::vector<Vec3f> pixels;
};

/// Reads a .hdr (RGBE) or an .exr; which it is, the file's own first bytes say. Throws UserError,
/// one line, for anything else, for damaged files, for values that are not finite and for pictures
/// of more than 2^26 pixels. Negative values are taken for 0, and the log says how many.
RadianceImage read_radiance_image(const std::filesystem::path& file);

/// Highest width and height of a picture.
inline constexpr int kMostPictureSide = 32768;

/// An OpenEXR file of one part, by the OpenEXR library: scan lines or tiles, channels R, G, B or Y
/// of any type and compression. Throws UserError that begins with `name`.
RadianceImage decode_exr(std::span<const unsigned char> bytes, const std::string& name);
bool is_exr(std::span<const unsigned char> bytes);

/// Throws UserError unless a picture of so many pixels can be in a file of so many bytes.
void check_picture_size(std::int64_t width, std::int64_t height, std::size_t file_bytes,
                        const std::string& name);

}  // namespace prt
