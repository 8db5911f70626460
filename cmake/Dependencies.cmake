# Every third-party library, all from Debian 12 packages (scripts/setup installs them).
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 CONFIG REQUIRED)
find_package(fmt 9 CONFIG REQUIRED)
find_package(spdlog 1.10 CONFIG REQUIRED)
find_package(nlohmann_json 3.11 CONFIG REQUIRED)
find_package(TinyGLTF CONFIG REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(OpenEXR 3 REQUIRED CONFIG)
pkg_check_modules(stb REQUIRED IMPORTED_TARGET stb)  # the decoder inside TinyGLTF
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
if(PRT_PLAYER_ONLY)
  set(PRT_HAVE_GL OFF)
  return()
endif()

# What baking takes beside these.
set(MPI_CXX_SKIP_MPICXX ON)  # no deprecated C++ bindings
find_package(MPI 3.1 REQUIRED COMPONENTS CXX)
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
  find_package(embree 3.13 CONFIG REQUIRED)
endif()
find_package(TBB 2021 CONFIG REQUIRED)
set(HDF5_PREFER_PARALLEL OFF)  # serial library, C interface
find_package(HDF5 1.10 REQUIRED COMPONENTS C)
find_package(CLI11 2.1 CONFIG REQUIRED)
find_package(yaml-cpp 0.7 CONFIG REQUIRED)
find_package(GTest CONFIG REQUIRED)

# The GL back end of the player; without these packages prt_play plays on the CPU alone.
if(PRT_GL)
  pkg_check_modules(epoxy IMPORTED_TARGET epoxy)
  pkg_check_modules(imgui IMPORTED_TARGET imgui)
  find_package(glfw3 3.3 CONFIG QUIET)
  if(epoxy_FOUND AND imgui_FOUND AND glfw3_FOUND)
    set(PRT_HAVE_GL ON)
  else()
    set(PRT_HAVE_GL OFF)
    message(STATUS "prt_play without GL: libepoxy-dev, libglfw3-dev and libimgui-dev are not all there")
  endif()
else()
  set(PRT_HAVE_GL OFF)
endif()
