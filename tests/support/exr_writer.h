// OpenEXR files for tests, by the library.
#pragma once

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

#include <cstring>
#include <functional>
#include <string>
#include <vector>

namespace prt::test {

class ExrWriter {
 public:
  int width = 0, height = 0;
  Imf::Compression compression = Imf::NO_COMPRESSION;
  Imf::PixelType type = Imf::FLOAT;
  std::vector<std::string> channels = {"B", "G", "R"};
  int first_line = 0;
  std::function<float(const std::string& channel, int x, int y)> value;

  [[nodiscard]] std::string encode() const {
    const Imath::Box2i window({0, first_line}, {width - 1, first_line + height - 1});
    Imf::Header header(window, window);
    header.compression() = compression;
    Imf::FrameBuffer frame;
    std::vector<std::vector<float>> floats(channels.size());
    std::vector<std::vector<half>> halves(channels.size());
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          floats[c].push_back(value(channels[c], x, y));
          halves[c].push_back(half(floats[c].back()));
        }
      }
      header.channels().insert(channels[c], Imf::Channel(type));
      const bool is_half = type == Imf::HALF;
      void* pixels = is_half ? static_cast<void*>(halves[c].data()) : floats[c].data();
      const std::size_t size = is_half ? sizeof(half) : sizeof(float);
      frame.insert(channels[c], Imf::Slice::Make(type, pixels, window.min, width, height, size,
                                                 size * static_cast<std::size_t>(width)));
    }
    Memory memory;
    {
      Imf::OutputFile file(memory, header, 0);
      file.setFrameBuffer(frame);
      file.writePixels(height);
    }
    return memory.bytes;
  }

 private:
  struct Memory : Imf::OStream {
    Memory() : OStream("memory") {}
    void write(const char from[], int count) override {
      bytes.resize(std::max(bytes.size(), at + static_cast<std::size_t>(count)));
      std::memcpy(bytes.data() + at, from, static_cast<std::size_t>(count));
      at += static_cast<std::size_t>(count);
    }
    std::uint64_t tellp() override { return at; }
    void seekp(std::uint64_t to) override { at = static_cast<std::size_t>(to); }
    std::string bytes;
    std::size_t at = 0;
  };
};

}  // namespace prt::test
