// PNG and JPEG through stb_image: a copy of our own, without the formats glTF does not have.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 32768
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <memory>

#include "scene/gltf_material.h"

namespace prt::gltf {
namespace {

/// No image of that many pixels is decoded ...
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 28;
/// ... and above 16 million none that has more than this per byte of file: a decompression bomb.
constexpr std::uint64_t kSafePixels = std::uint64_t{1} << 24;
constexpr std::uint64_t kPixelsPerByte = 1024;

}  // namespace

void decode_image(std::vector<std::byte> encoded, const Value& where, Texture& texture) {
  const auto* bytes = reinterpret_cast<const stbi_uc*>(encoded.data());
  if (encoded.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    where.fail("the image is larger than 2 GiB");
  }
  const int size = static_cast<int>(encoded.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(bytes, size, &width, &height, &channels) == 0) {
    where.fail(fmt::format("the image is neither a PNG nor a JPEG, or it is damaged ({})",
                           stbi_failure_reason()));
  }
  const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (pixels == 0 || pixels > kMaxPixels ||
      (pixels > kSafePixels && pixels > kPixelsPerByte * encoded.size())) {
    where.fail(fmt::format("an image of {} x {} pixels is not read", width, height));
  }
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> rgba(
      stbi_load_from_memory(bytes, size, &width, &height, &channels, 4), &stbi_image_free);
  if (!rgba) where.fail(fmt::format("the image cannot be decoded: {}", stbi_failure_reason()));
  texture.width = width;
  texture.height = height;
  texture.rgba.assign(rgba.get(), rgba.get() + 4 * pixels);
  texture.mime_type = encoded[0] == std::byte{0x89} ? "image/png" : "image/jpeg";
  texture.encoded = std::move(encoded);
}

}  // namespace prt::gltf
