// What the store's tests share.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "store/artifact_store.h"
#include "store/file_system.h"
#include "store/hdf5_image.h"

namespace prt {

/// A folder of the test's own, gone afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            (std::string("prt.") + info->test_suite_name() + "." + info->name() + "." +
             std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// 0, 1, 2, ... in any element type.
template <typename T>
std::vector<T> counting(std::size_t count) {
  std::vector<T> values(count);
  std::iota(values.begin(), values.end(), T{0});
  return values;
}

template <typename T>
void put_counting(Artifact& artifact, const std::string& name, std::vector<std::uint64_t> dims) {
  std::size_t count = 1;
  for (const auto side : dims) count *= side;
  const auto values = counting<T>(count);
  artifact.put(name, std::span<const T>(values), std::move(dims), "m", "the array " + name);
}

/// Holds every element type, groups, an empty array, a scalar and every kind of attribute.
inline Artifact varied_artifact() {
  Artifact artifact;
  put_counting<std::int8_t>(artifact, "int8", {3, 5});
  put_counting<std::int16_t>(artifact, "int16", {2, 3, 4});
  put_counting<std::uint8_t>(artifact, "uint8", {7});
  put_counting<std::uint16_t>(artifact, "group/uint16", {5, 2});
  put_counting<std::uint32_t>(artifact, "group/inner/uint32", {11});
  put_counting<std::uint64_t>(artifact, "uint64", {3});
  put_counting<float>(artifact, "float32", {4, 3});
  put_counting<double>(artifact, "float64", {2, 2});
  put_counting<float>(artifact, "empty", {0, 3});
  put_counting<float>(artifact, "scalar", {});
  artifact.attributes = {{"cluster", 7},
                         {"kind", "the store has this name, too"},
                         {"count", 42U},
                         {"largest", std::numeric_limits<std::uint64_t>::max()},
                         {"smallest", std::numeric_limits<std::int64_t>::min()},
                         {"energy", 0.1},
                         {"name", "a \"name\" with ü"},
                         {"nothing", ""},
                         {"decided", true},
                         {"missing", nullptr},
                         {"options", {{"rank", 50}, {"list", {1, 2.5, "x"}}}}};
  return artifact;
}

inline ArtifactLabel test_label() {
  return {"rays", hash_text("key"), 3, "Leonhardt & Bohn, eq. 8"};
}

inline void expect_equal(const Artifact& a, const Artifact& b) {
  EXPECT_EQ(a.attributes, b.attributes);
  ASSERT_EQ(a.datasets.size(), b.datasets.size());
  for (const auto& [name, dataset] : a.datasets) {
    const Dataset& other = b.at(name);
    EXPECT_EQ(dataset.type, other.type) << name;
    EXPECT_EQ(dataset.dims, other.dims) << name;
    EXPECT_EQ(dataset.bytes, other.bytes) << name;
    EXPECT_EQ(dataset.units, other.units) << name;
    EXPECT_EQ(dataset.meaning, other.meaning) << name;
  }
}

}  // namespace prt
