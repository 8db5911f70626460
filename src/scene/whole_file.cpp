#include "scene/whole_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <system_error>

#include "base/error.h"

namespace prt {
namespace fs = std::filesystem;

void refuse(std::string line) {
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  throw UserError(line);
}

std::vector<unsigned char> read_whole_file(const fs::path& path, const std::string& name,
                                           std::string_view what) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) refuse(fmt::format("{}: {} does not exist", name, what));
  if (!fs::is_regular_file(status))
    refuse(fmt::format("{}: {} is a folder or a device, not a file", name, what));
  std::ifstream stream(path, std::ios::binary);
  const std::uintmax_t size = fs::file_size(path, error);
  if (!stream || error) refuse(fmt::format("{}: {} cannot be read", name, what));
  std::vector<unsigned char> bytes(size);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(stream.gcount()) != size) {
    refuse(fmt::format("{}: {} cannot be read to its end", name, what));
  }
  return bytes;
}

}  // namespace prt
