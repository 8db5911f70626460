#include "base/image_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

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

/// A file that is not on the disk yet.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : OStream("a picture") {}
  void write(const char from[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ + size > bytes.size()) bytes.resize(at_ + size);
    std::memcpy(bytes.data() + at_, from, size);
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t to) override { at_ = static_cast<std::size_t>(to); }
  std::string bytes;

 private:
  std::size_t at_ = 0;
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
  Imf::Header header(width, height);
  header.compression() = Imf::NO_COMPRESSION;
  Imf::FrameBuffer frame;
  const std::size_t pixel = 3 * sizeof(float);
  const char* const names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
    // The library's slices serve reading, too, and so are not of const.
    auto* first = reinterpret_cast<char*>(const_cast<float*>(rgb.data() + c));
    frame.insert(names[c],
                 Imf::Slice(Imf::FLOAT, first, pixel, pixel * static_cast<std::size_t>(width)));
  }
  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(height);
  }  // whose end completes the table of lines
  return std::move(stream.bytes);
}

void write_exr(const std::filesystem::path& path, int width, int height,
               std::span<const float> rgb) {
  write_whole(path, encode_exr(width, height, rgb));
}

}  // namespace prt
