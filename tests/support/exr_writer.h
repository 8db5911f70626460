// OpenEXR files for tests, written from the format's description.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace prt::test {

class ExrWriter {
 public:
  int width = 0, height = 0;
  unsigned compression = 0;  ///< 0 none, 1 RLE, 2 ZIPS, 3 ZIP
  std::uint32_t type = 2;    ///< 1 half (values must be powers of two or 0), 2 float
  std::vector<std::string> channels = {"B", "G", "R"};
  int first_line = 0;
  std::function<float(const std::string& channel, int x, int y)> value;

  [[nodiscard]] std::string encode() const {
    std::string out = header();
    const int lines = compression == 3 ? 16 : 1;
    const int chunks = (height + lines - 1) / lines;
    std::string body;
    std::string table;
    const std::size_t begin = out.size() + 8 * static_cast<std::size_t>(chunks);
    for (int c = 0; c < chunks; ++c) {
      put<std::uint64_t>(table, begin + body.size());
      put<std::int32_t>(body, first_line + c * lines);
      const std::string packed = pack(plain(c * lines, std::min(lines, height - c * lines)));
      put<std::int32_t>(body, static_cast<std::int32_t>(packed.size()));
      body += packed;
    }
    return out + table + body;
  }

 private:
  template <typename T>
  static void put(std::string& out, T value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  static void attribute(std::string& out, const char* name, const char* kind,
                        const std::string& value) {
    out.append(name, std::strlen(name) + 1).append(kind, std::strlen(kind) + 1);
    put<std::int32_t>(out, static_cast<std::int32_t>(value.size()));
    out += value;
  }
  [[nodiscard]] std::string header() const {
    std::string out;
    put<std::uint32_t>(out, 20000630);
    put<std::uint32_t>(out, 2);
    std::string list;
    for (const std::string& channel : channels) {
      list.append(channel.c_str(), channel.size() + 1);
      put<std::uint32_t>(list, type);
      put<std::uint32_t>(list, 0);
      put<std::int32_t>(list, 1);
      put<std::int32_t>(list, 1);
    }
    attribute(out, "channels", "chlist", list + '\0');
    attribute(out, "compression", "compression", std::string(1, static_cast<char>(compression)));
    std::string box;
    for (const int side : {0, first_line, width - 1, first_line + height - 1}) {
      put<std::int32_t>(box, side);
    }
    attribute(out, "dataWindow", "box2i", box);
    attribute(out, "displayWindow", "box2i", box);
    return out + '\0';
  }
  [[nodiscard]] std::string plain(int first, int lines) const {
    std::string out;
    for (int y = first; y < first + lines; ++y) {
      for (const std::string& channel : channels) {
        for (int x = 0; x < width; ++x) {
          const float v = value(channel, x, y);
          std::uint32_t bits = 0;
          std::memcpy(&bits, &v, sizeof bits);
          if (type == 2) put<std::uint32_t>(out, bits);
          const std::uint32_t half = v == 0.0F ? 0 : ((bits >> 23) - 112) << 10;
          if (type == 1) put<std::uint16_t>(out, static_cast<std::uint16_t>(half));
        }
      }
    }
    return out;
  }
  [[nodiscard]] std::string pack(const std::string& plain) const {
    if (compression == 0) return plain;
    std::string split;
    for (const std::size_t odd : {0, 1}) {
      for (std::size_t i = odd; i < plain.size(); i += 2) split += plain[i];
    }
    std::string differences = split;
    for (std::size_t i = 1; i < split.size(); ++i) {
      differences[i] = static_cast<char>(split[i] - split[i - 1] + 128);
    }
    const std::string packed = compression == 1 ? runs(differences) : stored(differences);
    return packed.size() < plain.size() || compression != 1 ? packed : plain;
  }
  static std::string runs(const std::string& bytes) {
    std::string out;
    for (std::size_t i = 0; i < bytes.size();) {
      std::size_t same = 1;
      while (i + same < bytes.size() && bytes[i + same] == bytes[i] && same < 128) ++same;
      if (same > 1) {
        out += static_cast<char>(same - 1);
        out += bytes[i];
      } else {
        out += static_cast<char>(-1);
        out += bytes[i];
      }
      i += same;
    }
    return out;
  }
  /// A zlib stream of stored blocks.
  static std::string stored(const std::string& bytes) {
    std::string out = "\x78\x01";
    const std::size_t most = 65535;
    for (std::size_t i = 0; i < bytes.size(); i += most) {
      const std::size_t size = std::min(most, bytes.size() - i);
      out += static_cast<char>(i + size == bytes.size() ? 1 : 0);
      put<std::uint16_t>(out, static_cast<std::uint16_t>(size));
      put<std::uint16_t>(out, static_cast<std::uint16_t>(~size));
      out.append(bytes, i, size);
    }
    std::uint32_t a = 1, b = 0;
    for (const char c : bytes) {
      a = (a + static_cast<unsigned char>(c)) % 65521;
      b = (b + a) % 65521;
    }
    for (const int shift : {8, 0}) out += static_cast<char>(b >> shift);
    for (const int shift : {8, 0}) out += static_cast<char>(a >> shift);
    return out;
  }
};

}  // namespace prt::test
