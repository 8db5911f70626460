// Reads files that users name. Internal to scene/.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace prt {

/// Throws UserError with that text on one line: what files hold may have any characters.
[[noreturn]] void refuse(std::string line);

/// All bytes of a regular file. Throws UserError "`name`: `what` …" if it is none or cannot be
/// read.
std::vector<unsigned char> read_whole_file(const std::filesystem::path& path,
                                           const std::string& name, std::string_view what);

}  // namespace prt
