# One target per module: prt_<name>, from every .cpp of its folder.
#
#   prt_module(scene DEPENDS base PRIVATE_LIBS TinyGLTF::TinyGLTF PUBLIC_LIBS Eigen3::Eigen)
#
# A folder below a module becomes a target of its own only through its own prt_module call.
function(prt_module name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PUBLIC_LIBS;PRIVATE_LIBS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(TRANSFORM ARG_DEPENDS PREPEND prt_)
  if(NOT sources)  # headers only
    file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}_headers.cpp "")
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/${name}_headers.cpp)
  endif()
  add_library(prt_${name} STATIC ${sources})
  target_include_directories(prt_${name} PUBLIC ${CMAKE_SOURCE_DIR}/src)
  target_link_libraries(prt_${name} PUBLIC prt_flags ${ARG_DEPENDS} ${ARG_PUBLIC_LIBS}
                                    PRIVATE ${ARG_PRIVATE_LIBS})
  target_precompile_headers(prt_${name} REUSE_FROM prt_headers)
endfunction()

# Flags every target of ours shares.
add_library(prt_flags INTERFACE)
target_compile_options(prt_flags INTERFACE -Wall -Wextra $<$<BOOL:${PRT_WERROR}>:-Werror>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees overlapping copies in std::string operator+ where there are none (GCC bug 105651).
  target_compile_options(prt_flags INTERFACE -Wno-restrict)
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)  # nor is it silent about them in compiled headers
    target_compile_options(prt_flags INTERFACE -Wno-stringop-overflow -Wno-array-bounds)
  endif()
endif()
if(PRT_NATIVE)
  target_compile_options(prt_flags INTERFACE -march=native)
else()
  target_compile_options(prt_flags INTERFACE -march=x86-64-v3)
endif()
# A task is single-threaded, and the blocks in which products are summed up must not depend on the
# machine's caches: Eigen would ask the processor, and two hosts of one job would round differently.
target_compile_definitions(prt_flags INTERFACE EIGEN_DONT_PARALLELIZE EIGEN_NO_CPUID
  EIGEN_DEFAULT_L1_CACHE_SIZE=49152 EIGEN_DEFAULT_L2_CACHE_SIZE=1048576
  EIGEN_DEFAULT_L3_CACHE_SIZE=33554432)
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_definitions(prt_flags INTERFACE EIGEN_NO_DEBUG)
endif()
if(PRT_SANITIZE)
  target_compile_options(prt_flags INTERFACE -fsanitize=${PRT_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(prt_flags INTERFACE -fsanitize=${PRT_SANITIZE})
  if(PRT_SANITIZE MATCHES "undefined")
    target_compile_options(prt_flags INTERFACE -fno-sanitize-recover=undefined)
  endif()
  # Programs, not libraries, carry what the sanitizers are to overlook.
  target_sources(prt_flags INTERFACE $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${CMAKE_SOURCE_DIR}/cmake/sanitizer_defaults.cpp>)
endif()
# Assertions guard invariants in every build type; Eigen's own per-element checks would cost too much.
string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELEASE "${CMAKE_CXX_FLAGS_RELEASE}")
string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELWITHDEBINFO "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}")

# prt_precompiled_headers(NAME HEADERS ... LIBS ...): compiles the headers that most files include
# once; targets take them with target_precompile_headers(TARGET REUSE_FROM NAME). Half of a build's
# time otherwise. Every file still includes what it uses: the dev preset builds without.
function(prt_precompiled_headers name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBS" ${ARGN})
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp "")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE prt_flags Eigen3::Eigen fmt::fmt
                                        nlohmann_json::nlohmann_json ${ARG_LIBS})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS}
    <Eigen/Geometry> <fmt/format.h> <nlohmann/json.hpp> <algorithm> <array> <cmath> <filesystem>
    <functional> <map> <memory> <optional> <set> <span> <stdexcept> <string> <vector>)
endfunction()
prt_precompiled_headers(prt_headers)
