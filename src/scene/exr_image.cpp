#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfVersion.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "base/error.h"
#include "scene/radiance_image.h"
#include "scene/whole_file.h"

namespace prt {
namespace {

/// Larger tiles than this are taken for damage: the library asks for their memory first.
constexpr int kMostTileSide = 8192;

/// A file that was read already.
class MemoryStream : public Imf::IStream {
 public:
  MemoryStream(std::span<const unsigned char> bytes, const std::string& name)
      : IStream(name.c_str()), bytes_(bytes) {}
  bool read(char to[], int count) override {
    if (count < 0 || static_cast<std::size_t>(count) > bytes_.size() - at_) {
      throw std::runtime_error("it ends too early");
    }
    std::memcpy(to, bytes_.data() + at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::size_t>(count);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t to) override {
    if (to > bytes_.size()) throw std::runtime_error("a part of it lies beyond its end");
    at_ = static_cast<std::size_t>(to);
  }

 private:
  std::span<const unsigned char> bytes_;
  std::size_t at_ = 0;
};

/// Names of the channels that are red, green and blue: three, or one for all.
std::vector<std::string> colour_channels(const Imf::Header& header, const std::string& name) {
  const Imf::ChannelList& channels = header.channels();
  std::vector<std::string> chosen = {"R", "G", "B"};
  const auto missing = [&](const std::string& channel) {
    return channels.findChannel(channel.c_str()) == nullptr;
  };
  if (std::ranges::any_of(chosen, missing)) chosen = {"Y"};
  if (missing(chosen.front())) {
    refuse(name + ": the .exr has neither channels R, G and B nor Y; write it with them");
  }
  for (const std::string& channel : chosen) {
    const Imf::Channel& found = channels[channel.c_str()];
    if (found.xSampling != 1 || found.ySampling != 1) {
      refuse(fmt::format(
          "{}: the .exr has fewer values than pixels in channel {}; write it without subsampling",
          name, channel));
    }
  }
  return chosen;
}

RadianceImage decode(std::span<const unsigned char> bytes, const std::string& name) {
  MemoryStream stream(bytes, name);
  Imf::MultiPartInputFile file(stream, 0, false);
  if (file.parts() != 1) refuse(name + ": the .exr has several parts; write one with one");
  const Imf::Header& header = file.header(0);
  if (header.hasType() && Imf::isDeepData(header.type())) {
    refuse(name + ": the .exr holds deep pixels; flatten it");
  }
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  check_picture_size(width, height, bytes.size(), name);
  const std::vector<std::string> channels = colour_channels(header, name);
  RadianceImage image{static_cast<int>(width), static_cast<int>(height), {}};
  image.pixels.assign(static_cast<std::size_t>(width * height), Vec3f::Zero());
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    frame.insert(channels[c],
                 Imf::Slice::Make(Imf::FLOAT, image.pixels.front().data() + c, window.min, width,
                                  height, sizeof(Vec3f), sizeof(Vec3f) * width));
  }
  Imf::InputPart part(file, 0);
  part.setFrameBuffer(frame);
  part.readPixels(window.min.y, window.max.y);
  if (channels.size() == 1) {
    for (Vec3f& pixel : image.pixels) pixel.setConstant(pixel.x());
  }
  return image;
}

}  // namespace

bool is_exr(std::span<const unsigned char> bytes) {
  return bytes.size() >= 4 && Imf::isImfMagic(reinterpret_cast<const char*>(bytes.data()));
}

RadianceImage decode_exr(std::span<const unsigned char> bytes, const std::string& name) {
  Imf::Header::setMaxImageSize(kMostPictureSide, kMostPictureSide);
  Imf::Header::setMaxTileSize(kMostTileSide, kMostTileSide);
  try {
    return decode(bytes, name);
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& e) {  // what the library throws names itself, or memory
    refuse(fmt::format("{}: the .exr is damaged ({})", name, e.what()));
  }
}

}  // namespace prt
