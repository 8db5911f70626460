# cmake -DOUTPUT=FILE.cpp -DSHADERS="a.glsl;b.glsl" -P embed_shaders.cmake
# Writes a C++ file that holds the shaders' text (shader_source.h).
set(entries "")
foreach(shader ${SHADERS})
  file(READ ${shader} text)
  get_filename_component(name ${shader} NAME)
  string(APPEND entries "  if (name == \"${name}\") return R\"glsl(${text})glsl\";\n")
endforeach()
file(WRITE ${OUTPUT} "// Made from the shaders beside the sources.
#include <string_view>
namespace prt::gl {
std::string_view shader_source(std::string_view name);
std::string_view shader_source(std::string_view name) {
${entries}  return {};
}
}  // namespace prt::gl
")
