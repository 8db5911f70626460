// PNG and JPEG through tinygltf's decoder, which is stb_image: what it would let through is refused
// here.
#include <fmt/format.h>
#include <stb_image.h>
#include <tiny_gltf.h>

#include <array>
#include <cstdint>
#include <limits>

#include "scene/gltf_material.h"

namespace prt::gltf {
namespace {

constexpr std::array<unsigned char, 8> kPng = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::array<unsigned char, 3> kJpeg = {0xff, 0xd8, 0xff};

/// No image of that many pixels, or that wide or high, is decoded ...
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 28;
constexpr int kMaxSide = 32768;
/// ... and above 16 million none that has more than this per byte of file: a decompression bomb.
constexpr std::uint64_t kSafePixels = std::uint64_t{1} << 24;
constexpr std::uint64_t kPixelsPerByte = 1024;

template <std::size_t N>
bool begins_with(const std::vector<unsigned char>& bytes,
                 const std::array<unsigned char, N>& magic) {
  return bytes.size() >= N && std::equal(magic.begin(), magic.end(), bytes.begin());
}

/// stb_image also reads formats that glTF does not have.
std::string mime_type(const std::vector<unsigned char>& encoded, const Value& where) {
  if (begins_with(encoded, kPng)) return "image/png";
  if (begins_with(encoded, kJpeg)) return "image/jpeg";
  where.fail("the image is neither a PNG nor a JPEG");
}

void check_size(const std::vector<unsigned char>& encoded, const Value& where) {
  if (encoded.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    where.fail("the image is larger than 2 GiB");
  }
  const int size = static_cast<int>(encoded.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(encoded.data(), size, &width, &height, &channels) == 0) {
    where.fail(fmt::format("the image is damaged ({})", stbi_failure_reason()));
  }
  const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  // tinygltf counts the bytes of an image in int: 4 channels of 16 bits take twice as many.
  const bool wide = stbi_is_16_bit_from_memory(encoded.data(), size) != 0;
  if (pixels == 0 || width > kMaxSide || height > kMaxSide ||
      pixels > (wide ? kMaxPixels / 2 : kMaxPixels) ||
      (pixels > kSafePixels && pixels > kPixelsPerByte * encoded.size())) {
    where.fail(fmt::format("an image of {} x {} pixels is not read", width, height));
  }
}

}  // namespace

void decode_image(const std::vector<unsigned char>& encoded, const Value& where, Texture& texture) {
  texture.mime_type = mime_type(encoded, where);
  check_size(encoded, where);
  tinygltf::Image image;
  std::string error;
  std::string warning;
  if (!tinygltf::LoadImageData(&image, 0, &error, &warning, 0, 0, encoded.data(),
                               static_cast<int>(encoded.size()), nullptr)) {
    where.fail(fmt::format("the image cannot be decoded: {}", stbi_failure_reason()));
  }
  if (image.bits == 16) {  // the high byte of each sample, little-endian
    for (std::size_t i = 0; 2 * i < image.image.size(); ++i) {
      image.image[i] = image.image[2 * i + 1];
    }
    image.image.resize(image.image.size() / 2);
  }
  texture.width = image.width;
  texture.height = image.height;
  texture.rgba = std::move(image.image);
  const auto bytes = std::as_bytes(std::span(encoded));
  texture.encoded.assign(bytes.begin(), bytes.end());
}

}  // namespace prt::gltf
