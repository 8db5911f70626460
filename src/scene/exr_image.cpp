// OpenEXR, as its file layout is described by the Academy Software Foundation ("OpenEXR File
// Layout"): single-part files of scan lines. Every length is checked before it is used.
#include <fmt/format.h>
#include <stb_image.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>

#include "scene/radiance_image.h"
#include "scene/whole_file.h"

namespace prt {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kLongNames = 0x400;  ///< the one flag that changes nothing here
constexpr std::size_t kMostName = 255;
constexpr std::size_t kMostChunkBytes = std::size_t{1} << 30;

enum Compression : unsigned { kStored = 0, kRle = 1, kZips = 2, kZip = 3 };
constexpr std::array<std::string_view, 10> kCompressions = {"none",  "RLE", "ZIPS", "ZIP",  "PIZ",
                                                            "PXR24", "B44", "B44A", "DWAA", "DWAB"};

enum PixelType : std::uint32_t { kUint = 0, kHalf = 1, kFloat = 2 };

float half_to_float(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 31;
  const int fraction = bits & 1023;
  float value = 0.0F;
  if (exponent == 31) {
    value = fraction == 0 ? kInfinity : std::numeric_limits<float>::quiet_NaN();
  } else if (exponent == 0) {
    value = std::ldexp(static_cast<float>(fraction), -24);
  } else {
    value = std::ldexp(static_cast<float>(1024 + fraction), exponent - 25);
  }
  return (bits & 0x8000U) != 0 ? -value : value;
}

struct Channel {
  std::string name;
  std::uint32_t type = kHalf;
  [[nodiscard]] std::size_t bytes() const { return type == kHalf ? 2 : 4; }
};

class Exr {
 public:
  Exr(std::span<const unsigned char> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  RadianceImage decode() {
    read_header();
    choose_channels();
    RadianceImage image{static_cast<int>(width_), static_cast<int>(height_), {}};
    image.pixels.assign(static_cast<std::size_t>(width_ * height_), Vec3f::Zero());
    const std::int64_t lines = compression_ == kZip ? 16 : 1;
    const std::int64_t chunks = (height_ + lines - 1) / lines;
    const std::size_t table = at_;
    std::vector<bool> seen(static_cast<std::size_t>(chunks), false);
    for (std::int64_t c = 0; c < chunks; ++c) {
      at_ = table + 8 * static_cast<std::size_t>(c);
      const auto offset = take<std::uint64_t>();
      if (offset > bytes_.size()) damaged("a chunk begins beyond its end");
      at_ = static_cast<std::size_t>(offset);
      const std::int64_t first = static_cast<std::int64_t>(take<std::int32_t>()) - top_;
      if (first < 0 || first >= height_ || first % lines != 0)
        damaged("a chunk is at no such line");
      const auto chunk = static_cast<std::size_t>(first / lines);
      if (seen[chunk]) damaged("a chunk is there twice");
      seen[chunk] = true;
      read_chunk(first, std::min(lines, height_ - first), image);
    }
    return image;
  }

 private:
  [[noreturn]] void damaged(std::string_view why) const {
    refuse(fmt::format("{}: the .exr is damaged: {}", name_, why));
  }
  [[noreturn]] void unread(std::string_view what) const {
    refuse(
        fmt::format("{}: {} OpenEXR files are not read; save it as scan lines with ZIP compression",
                    name_, what));
  }

  template <typename T>
  T take() {
    T value{};
    const auto from = take_bytes(sizeof value);
    std::memcpy(&value, from.data(), sizeof value);
    return value;
  }
  std::span<const unsigned char> take_bytes(std::size_t count) {
    if (at_ > bytes_.size() || count > bytes_.size() - at_) damaged("it ends too early");
    const auto part = bytes_.subspan(at_, count);
    at_ += count;
    return part;
  }
  std::string take_name() {
    std::string text;
    for (;;) {
      const auto c = static_cast<char>(take<unsigned char>());
      if (c == '\0') return text;
      text.push_back(c);
      if (text.size() > kMostName) damaged("a name has no end");
    }
  }

  void read_header() {
    at_ = 4;
    const auto version = take<std::uint32_t>();
    if ((version & 0xffU) != kVersion) unread("other versions of");
    if ((version & ~(0xffU | kLongNames)) != 0) unread("tiled, deep and multi-part");
    for (;;) {
      const std::string name = take_name();
      if (name.empty()) break;
      const std::string type = take_name();
      const auto size = take<std::uint32_t>();
      const std::size_t end = at_ + size;
      const auto value = take_bytes(size);
      if (name == "channels" && type == "chlist") read_channels(end - size, end);
      if (name == "compression" && size == 1) compression_ = value[0];
      if (name == "dataWindow" && size == 16) read_window(end - size);
      at_ = end;
    }
    if (width_ == 0) damaged("it has no data window");
    check_picture_size(width_, height_, bytes_.size(), name_);
    if (compression_ > kZip) {
      unread(compression_ < kCompressions.size()
                 ? fmt::format("{}-compressed", kCompressions[compression_])
                 : "strangely compressed");
    }
  }

  void read_window(std::size_t from) {
    at_ = from;
    std::array<std::int64_t, 4> box{};
    for (std::int64_t& side : box) side = take<std::int32_t>();
    top_ = box[1];
    width_ = box[2] - box[0] + 1;
    height_ = box[3] - box[1] + 1;
    if (width_ < 1 || height_ < 1) damaged("its data window is empty");
  }

  void read_channels(std::size_t from, std::size_t end) {
    at_ = from;
    channels_.clear();
    while (at_ < end) {
      Channel channel;
      channel.name = take_name();
      if (channel.name.empty()) break;
      channel.type = take<std::uint32_t>();
      if (channel.type > kFloat) damaged("a channel has an unknown type");
      take<std::uint32_t>();
      const auto across = take<std::int32_t>();
      const auto down = take<std::int32_t>();
      if (across != 1 || down != 1) unread("subsampled");
      channels_.push_back(channel);
    }
  }

  /// Which of the channels each colour is read from: R, G, B, or Y for all three.
  void choose_channels() {
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      const std::string& name = channels_[i].name;
      if (name == "R" || name == "Y") source_[0] = static_cast<int>(i);
      if (name == "G" || name == "Y") source_[1] = static_cast<int>(i);
      if (name == "B" || name == "Y") source_[2] = static_cast<int>(i);
    }
    for (const int s : source_) {
      if (s < 0) {
        refuse(name_ + ": the .exr has no channels R, G and B, and no Y either");
      }
    }
  }

  void read_chunk(std::int64_t first, std::int64_t lines, RadianceImage& image) {
    std::size_t pixel = 0;
    for (const Channel& c : channels_) pixel += c.bytes();
    const auto width = static_cast<std::size_t>(width_);
    const std::size_t wanted = pixel * width * static_cast<std::size_t>(lines);
    if (wanted > kMostChunkBytes) unread("such wide or many-channelled");
    const auto size = take<std::int32_t>();
    if (size < 0) damaged("a chunk has a negative size");
    const std::vector<unsigned char> values =
        unpacked(take_bytes(static_cast<std::size_t>(size)), wanted);
    for (std::int64_t line = 0; line < lines; ++line) {
      const unsigned char* row = values.data() + static_cast<std::size_t>(line) * pixel * width;
      std::vector<const unsigned char*> begin;
      for (const Channel& c : channels_) {
        begin.push_back(row);
        row += c.bytes() * width;
      }
      for (std::size_t x = 0; x < width; ++x) {
        Vec3f& out = image.pixels[static_cast<std::size_t>(first + line) * width + x];
        for (int c = 0; c < 3; ++c) {
          const auto from = static_cast<std::size_t>(source_[static_cast<std::size_t>(c)]);
          out[c] = number(begin[from] + x * channels_[from].bytes(), channels_[from].type);
        }
      }
    }
  }

  static float number(const unsigned char* from, std::uint32_t type) {
    if (type == kHalf) {
      std::uint16_t bits = 0;
      std::memcpy(&bits, from, sizeof bits);
      return half_to_float(bits);
    }
    if (type == kFloat) {
      float value = 0.0F;
      std::memcpy(&value, from, sizeof value);
      return value;
    }
    std::uint32_t whole = 0;
    std::memcpy(&whole, from, sizeof whole);
    return static_cast<float>(whole);
  }

  /// A chunk that compression would make larger is stored as it is.
  std::vector<unsigned char> unpacked(std::span<const unsigned char> packed,
                                      std::size_t wanted) const {
    if (packed.size() == wanted || compression_ == kStored) {
      if (packed.size() != wanted) damaged("a chunk has another size than its lines");
      return {packed.begin(), packed.end()};
    }
    std::vector<unsigned char> bytes(wanted);
    if (compression_ == kRle) {
      expand_runs(packed, bytes);
    } else {
      const int made = stbi_zlib_decode_buffer(
          reinterpret_cast<char*>(bytes.data()), static_cast<int>(wanted),
          reinterpret_cast<const char*>(packed.data()), static_cast<int>(packed.size()));
      if (made < 0 || static_cast<std::size_t>(made) != wanted) {
        damaged("a chunk cannot be decompressed");
      }
    }
    for (std::size_t i = 1; i < wanted; ++i) {  // bytes are differences
      bytes[i] = static_cast<unsigned char>(bytes[i - 1] + bytes[i] - 128);
    }
    std::vector<unsigned char> woven(wanted);  // even places first, then the odd ones
    const std::size_t half = (wanted + 1) / 2;
    for (std::size_t i = 0; i < wanted; ++i) woven[i] = bytes[i % 2 == 0 ? i / 2 : half + i / 2];
    return woven;
  }

  void expand_runs(std::span<const unsigned char> packed, std::vector<unsigned char>& out) const {
    std::size_t made = 0;
    for (std::size_t i = 0; i < packed.size();) {
      const int byte = packed[i++];
      const int count = byte < 128 ? byte : byte - 256;
      const bool literal = count < 0;
      const auto length = static_cast<std::size_t>(literal ? -count : count + 1);
      const std::size_t read = literal ? length : 1;
      if (read > packed.size() - i || length > out.size() - made) {
        damaged("a run goes beyond its chunk");
      }
      for (std::size_t k = 0; k < length; ++k) out[made++] = packed[i + (literal ? k : 0)];
      i += read;
    }
    if (made != out.size()) damaged("a chunk ends too early");
  }

  std::span<const unsigned char> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
  std::vector<Channel> channels_;
  unsigned compression_ = kStored;
  std::int64_t top_ = 0, width_ = 0, height_ = 0;
  std::array<int, 3> source_ = {-1, -1, -1};
};

}  // namespace

bool is_exr(std::span<const unsigned char> bytes) {
  std::uint32_t magic = 0;
  if (bytes.size() < 8) return false;
  std::memcpy(&magic, bytes.data(), sizeof magic);
  return magic == kMagic;
}

RadianceImage decode_exr(std::span<const unsigned char> bytes, const std::string& name) {
  return Exr(bytes, name).decode();
}

}  // namespace prt
