// The text of the shaders in shaders/, put into the program when it is built.
#pragma once

#include <string_view>

namespace prt::gl {

/// Empty if there is no such file.
std::string_view shader_source(std::string_view name);

}  // namespace prt::gl
