# Every third-party library, all from Debian 12 packages (scripts/setup installs them).
set(MPI_CXX_SKIP_MPICXX ON)  # no deprecated C++ bindings
find_package(Threads REQUIRED)
find_package(MPI 3.1 REQUIRED COMPONENTS CXX)
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
  find_package(embree 3.13 CONFIG REQUIRED)
endif()
find_package(TBB 2021 CONFIG REQUIRED)
find_package(Eigen3 3.4 CONFIG REQUIRED)
set(HDF5_PREFER_PARALLEL OFF)  # serial library, C interface
find_package(HDF5 1.10 REQUIRED COMPONENTS C)
find_package(fmt 9 CONFIG REQUIRED)
find_package(spdlog 1.10 CONFIG REQUIRED)
find_package(CLI11 2.1 CONFIG REQUIRED)
find_package(yaml-cpp 0.7 CONFIG REQUIRED)
find_package(nlohmann_json 3.11 CONFIG REQUIRED)
find_package(TinyGLTF CONFIG REQUIRED)
find_package(GTest CONFIG REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(stb REQUIRED IMPORTED_TARGET stb)  # the decoder inside TinyGLTF
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
