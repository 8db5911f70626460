#include "base/image_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "base/error.h"

// The one place where stb's PNG writer is compiled.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace prt {

namespace {

[[noreturn]] void cannot_write(const std::filesystem::path& path) {
  throw UserError(path.string() + ": cannot write the picture: " + std::strerror(errno));
}

void append(void* out, void* data, int size) {
  static_cast<std::string*>(out)->append(static_cast<const char*>(data),
                                         static_cast<std::size_t>(size));
}

void check_size(int width, int height, std::span<const std::uint8_t> rgb) {
  if (width <= 0 || height <= 0 || rgb.size() != 3 * std::size_t(width) * std::size_t(height)) {
    throw std::logic_error("picture: size and number of pixels differ");
  }
}

}  // namespace

std::string encode_jpeg(int width, int height, std::span<const std::uint8_t> rgb, int quality) {
  check_size(width, height, rgb);
  std::string jpeg;
  if (stbi_write_jpg_to_func(append, &jpeg, width, height, 3, rgb.data(), quality) == 0) {
    throw std::runtime_error("the JPEG encoder failed");
  }
  return jpeg;
}

void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint8_t> rgb) {
  check_size(width, height, rgb);
  std::string png;
  if (stbi_write_png_to_func(append, &png, width, height, 3, rgb.data(), 3 * width) == 0) {
    throw std::runtime_error(path.string() + ": the PNG encoder failed");
  }
  const std::filesystem::path temporary = path.string() + "." + std::to_string(getpid()) + ".tmp";
  errno = 0;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  if (!file) cannot_write(path);
  file.write(png.data(), static_cast<std::streamsize>(png.size()));
  file.close();
  std::error_code error;
  if (!file || (std::filesystem::rename(temporary, path, error), error)) {
    if (error) errno = error.value();
    const int reason = errno;
    std::filesystem::remove(temporary, error);
    errno = reason;
    cannot_write(path);
  }
}

}  // namespace prt
