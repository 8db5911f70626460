#include "base/image_file.h"

#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "base/atomic_file.h"

// The one place where stb's PNG writer is compiled.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace prt {

namespace {

void append(void* out, void* data, int size) {
  static_cast<std::string*>(out)->append(static_cast<const char*>(data),
                                         static_cast<std::size_t>(size));
}

void check_size(int width, int height, std::size_t values) {
  if (width <= 0 || height <= 0 || values != 3 * std::size_t(width) * std::size_t(height)) {
    throw std::logic_error("picture: size and number of pixels differ");
  }
}

void write_whole(const std::filesystem::path& path, const std::string& bytes) {
  write_file_atomically(path, std::as_bytes(std::span(bytes)));
}

/// An OpenEXR file as it grows ("OpenEXR File Layout", openexr.com): little-endian numbers, names
/// that end in a zero.
struct ExrBytes {
  std::string bytes;
  template <typename T>
  void put(T value) {
    static_assert(std::endian::native == std::endian::little);
    const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    bytes.append(raw.data(), raw.size());
  }
  void name(const char* text) { bytes.append(text, std::strlen(text) + 1); }
  void attribute(const char* called, const char* type, std::uint32_t size) {
    name(called);
    name(type);
    put(size);
  }
};

}  // namespace

std::string encode_jpeg(int width, int height, std::span<const std::uint8_t> rgb, int quality) {
  check_size(width, height, rgb.size());
  std::string jpeg;
  if (stbi_write_jpg_to_func(append, &jpeg, width, height, 3, rgb.data(), quality) == 0) {
    throw std::runtime_error("the JPEG encoder failed");
  }
  return jpeg;
}

void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint8_t> rgb) {
  check_size(width, height, rgb.size());
  std::string png;
  if (stbi_write_png_to_func(append, &png, width, height, 3, rgb.data(), 3 * width) == 0) {
    throw std::runtime_error(path.string() + ": the PNG encoder failed");
  }
  write_whole(path, png);
}

std::string encode_exr(int width, int height, std::span<const float> rgb) {
  check_size(width, height, rgb.size());
  ExrBytes exr;
  exr.put(std::uint32_t{20000630});  // magic number
  exr.put(std::uint32_t{2});         // version, scan lines of one part
  exr.attribute("channels", "chlist", 3 * 18 + 1);
  for (const char* channel : {"B", "G", "R"}) {
    exr.name(channel);
    for (const std::uint32_t n : {2U, 0U, 1U, 1U}) exr.put(n);  // float; linear; every pixel
  }
  exr.name("");
  exr.attribute("compression", "compression", 1);
  exr.put(std::uint8_t{0});  // none
  for (const char* window : {"dataWindow", "displayWindow"}) {
    exr.attribute(window, "box2i", 16);
    for (const int n : {0, 0, width - 1, height - 1}) exr.put(n);
  }
  exr.attribute("lineOrder", "lineOrder", 1);
  exr.put(std::uint8_t{0});  // increasing
  exr.attribute("pixelAspectRatio", "float", 4);
  exr.put(1.0F);
  exr.attribute("screenWindowCenter", "v2f", 8);
  exr.put(0.0F);
  exr.put(0.0F);
  exr.attribute("screenWindowWidth", "float", 4);
  exr.put(1.0F);
  exr.name("");
  const std::uint64_t line = 4ULL * 3ULL * static_cast<std::uint64_t>(width);
  const std::uint64_t first = exr.bytes.size() + 8ULL * static_cast<std::uint64_t>(height);
  for (int y = 0; y < height; ++y) exr.put(first + static_cast<std::uint64_t>(y) * (line + 8));
  for (int y = 0; y < height; ++y) {
    exr.put(y);
    exr.put(static_cast<std::uint32_t>(line));
    for (const std::size_t channel : {2U, 1U, 0U}) {
      for (int x = 0; x < width; ++x) {
        exr.put(rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(x)) +
                    channel]);
      }
    }
  }
  return exr.bytes;
}

void write_exr(const std::filesystem::path& path, int width, int height,
               std::span<const float> rgb) {
  write_whole(path, encode_exr(width, height, rgb));
}

}  // namespace prt
