#include "scene/radiance_image.h"

#include <fmt/format.h>
#include <stb_image.h>

#include <cmath>
#include <limits>
#include <memory>

#include "base/log.h"
#include "scene/whole_file.h"

namespace prt {
namespace {

constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;
/// The densest runs of .hdr hold 16 pixels per byte; deflate can do a thousand bytes.
constexpr std::int64_t kPixelsPerByte = 1024;

RadianceImage decode_hdr(const std::vector<unsigned char>& bytes, const std::string& name) {
  const int size = static_cast<int>(bytes.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0) {
    refuse(fmt::format("{}: the .hdr is damaged ({})", name, stbi_failure_reason()));
  }
  check_picture_size(width, height, bytes.size(), name);
  const std::unique_ptr<float, void (*)(void*)> values(
      stbi_loadf_from_memory(bytes.data(), size, &width, &height, &channels, 3), stbi_image_free);
  if (!values) {
    refuse(fmt::format("{}: the .hdr is damaged ({})", name, stbi_failure_reason()));
  }
  RadianceImage image{width, height, {}};
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.pixels.reserve(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    image.pixels.emplace_back(Eigen::Map<const Vec3f>(values.get() + 3 * i));
  }
  return image;
}

}  // namespace

void check_picture_size(std::int64_t width, std::int64_t height, std::size_t file_bytes,
                        const std::string& name) {
  if (width < 1 || height < 1 || width > kMostPictureSide || height > kMostPictureSide ||
      width * height > kMostPixels ||
      width * height > kPixelsPerByte * static_cast<std::int64_t>(file_bytes)) {
    refuse(fmt::format("{}: a picture of {} x {} pixels in {} bytes is not read", name, width,
                       height, file_bytes));
  }
}

RadianceImage read_radiance_image(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::vector<unsigned char> bytes = read_whole_file(file, name, "the environment map");
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    refuse(name + ": the environment map is larger than 2 GiB");
  }
  const bool is_hdr = stbi_is_hdr_from_memory(bytes.data(), static_cast<int>(bytes.size())) != 0;
  if (!is_hdr && !is_exr(bytes)) {
    refuse(name + ": it is neither a Radiance .hdr nor an OpenEXR file; convert it to one");
  }
  RadianceImage image = is_hdr ? decode_hdr(bytes, name) : decode_exr(bytes, name);
  std::size_t not_finite = 0, negative = 0;
  for (Vec3f& pixel : image.pixels) {
    if (!pixel.allFinite()) ++not_finite;
    if (pixel.minCoeff() < 0.0F) ++negative;
    pixel = pixel.cwiseMax(0.0F);
  }
  if (not_finite > 0) {
    refuse(fmt::format("{}: {} pixels are not finite; mend the picture", name, not_finite));
  }
  if (negative > 0) log::warn("{}: {} pixels of negative radiance are taken for 0", name, negative);
  return image;
}

}  // namespace prt
