#include "store/hdf5_image.h"

#include <cstdio>
#include <limits>
#include <random>

#include "store/seal.h"
#include "store_fixtures.h"

namespace prt {
namespace {

/// Prints a content hash and ends: run by the test of determinism across processes.
constexpr const char* kPrintHashFilter = "Hdf5Image.DISABLED_PrintContentHash";

/// Some chunks wide and no multiple of them, so that the last chunk is padded.
Artifact large_artifact() {
  Artifact artifact = varied_artifact();
  put_counting<std::uint16_t>(artifact, "large", {1013, 2016});
  put_counting<float>(artifact, "wide", {1, 700001});
  return artifact;
}

Digest content_of(const Artifact& artifact) { return verify_seal(to_hdf5(artifact, test_label())); }

bool is_refused(std::span<const std::byte> file) {
  try {
    from_hdf5(file);
    return false;
  } catch (const UnsoundData&) {
    return true;
  }
}

TEST(Hdf5Image, GivesBackEveryTypeShapeAndAttribute) {
  const Artifact artifact = large_artifact();
  const LabelledArtifact back = from_hdf5(to_hdf5(artifact, test_label()));
  EXPECT_EQ(back.label, test_label());
  expect_equal(artifact, back.artifact);
  for (const auto& [name, value] : artifact.attributes.items()) {
    const nlohmann::json& now = back.artifact.attributes.at(name);
    EXPECT_EQ(value.is_number_integer(), now.is_number_integer()) << name;
    if (value.is_number_integer()) continue;
    EXPECT_EQ(value.type(), now.type()) << name;
  }
}

TEST(Hdf5Image, IntegersAreStoredByValueAndNotByTypeInMemory) {
  Artifact in_process;
  in_process.attributes = {{"bounces", 3}, {"lowest", -3}};
  Artifact travelled;
  travelled.attributes = nlohmann::json::parse(in_process.attributes.dump());
  ASSERT_NE(in_process.attributes["bounces"].type(), travelled.attributes["bounces"].type());
  EXPECT_EQ(content_of(in_process), content_of(travelled));
}

TEST(Hdf5Image, KeepsValuesThatAreNoNumbers) {
  Artifact artifact;
  const std::vector<float> values = {std::numeric_limits<float>::quiet_NaN(), kInfinity, -0.0F};
  artifact.put("odd", std::span<const float>(values), {3}, "1", "odd values");
  artifact.attributes["infinite"] = std::numeric_limits<double>::infinity();
  expect_equal(artifact, from_hdf5(to_hdf5(artifact, test_label())).artifact);
}

TEST(Hdf5Image, KeepsLongTexts) {
  Artifact artifact;
  artifact.attributes["long"] = std::string(200000, 'x');  // beyond an object header's 64 KiB
  for (int i = 0; i < 100; ++i) artifact.attributes["many" + std::to_string(i)] = i;
  expect_equal(artifact, from_hdf5(to_hdf5(artifact, test_label())).artifact);
}

TEST(Hdf5Image, RefusesToStoreWhatCannotComeBack) {
  for (const char* name : {"", "/a", "a/", "a//b", "./a"}) {
    Artifact artifact;
    put_counting<float>(artifact, name, {2});
    EXPECT_THROW(to_hdf5(artifact, test_label()), std::logic_error) << name;
  }
  for (const char* name : {"", "json:x"}) {
    Artifact artifact;
    artifact.attributes[name] = 1;
    EXPECT_THROW(to_hdf5(artifact, test_label()), std::logic_error) << name;
  }
  Artifact artifact;
  put_counting<float>(artifact, "a", {2});
  artifact.datasets["a"].dims = {3};
  EXPECT_THROW(to_hdf5(artifact, test_label()), std::logic_error);
}

TEST(Hdf5Image, EqualArtifactsGiveEqualBytes) {
  const auto first = to_hdf5(large_artifact(), test_label());
  // Whatever lay in freed memory must not show.
  for (int i = 0; i < 8; ++i) std::vector<std::byte>(1 << 21, std::byte(0x5A + i)).clear();
  EXPECT_EQ(first, to_hdf5(large_artifact(), test_label()));
}

TEST(Hdf5Image, ContentHashTellsArtifactsApart) {
  Artifact other = varied_artifact();
  other.datasets["float32"].bytes[5] ^= std::byte{1};
  EXPECT_NE(content_of(varied_artifact()), content_of(other));
}

TEST(Hdf5Image, DISABLED_PrintContentHash) {
  std::printf("content=%s\n", content_of(large_artifact()).hex().c_str());
}

TEST(Hdf5Image, EqualBytesInAnotherProcess) {
  // Another environment and heap: MALLOC_PERTURB_ fills fresh memory with rubbish.
  const std::string command =
      "MALLOC_PERTURB_=165 /proc/" + std::to_string(getpid()) +
      "/exe --gtest_also_run_disabled_tests --gtest_filter=" + kPrintHashFilter;
  std::FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string output;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output += static_cast<char>(c);
  ASSERT_EQ(pclose(pipe), 0) << output;
  EXPECT_NE(output.find("content=" + content_of(large_artifact()).hex()), std::string::npos)
      << output;
}

TEST(Hdf5Image, EveryFlippedBitIsNoticed) {
  Artifact artifact;
  put_counting<float>(artifact, "a", {4, 2});
  auto file = to_hdf5(artifact, test_label());
  ASSERT_FALSE(is_refused(file));
  for (std::size_t at = 0; at < file.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      file[at] ^= std::byte(1 << bit);
      ASSERT_TRUE(is_refused(file)) << "byte " << at << " bit " << bit;
      file[at] ^= std::byte(1 << bit);
    }
  }
}

TEST(Hdf5Image, EveryTruncationIsNoticed) {
  const auto file = to_hdf5(varied_artifact(), test_label());
  for (std::size_t length = 0; length < file.size(); ++length) {
    ASSERT_TRUE(is_refused(std::span(file).first(length))) << length;
  }
}

/// Bytes before the seal, changed by `change`, with a seal that fits them.
template <typename Change>
std::vector<std::byte> resealed(std::vector<std::byte> file, Change&& change) {
  std::vector<std::byte> seal(file.end() - kSealBytes, file.end());
  file.resize(file.size() - kSealBytes);
  change(file);
  const std::uint64_t length = file.size();
  const Digest digest = hash_bytes(file);
  std::memcpy(seal.data() + 8, &length, 8);
  std::memcpy(seal.data() + 16, &digest.high, 8);
  std::memcpy(seal.data() + 24, &digest.low, 8);
  file.insert(file.end(), seal.begin(), seal.end());
  return file;
}

/// Damage that a seal was forged for is HDF5's to notice. libhdf5 1.10.8 then frees what it never
/// set: memory that the address sanitizer fills makes that a crash.
TEST(Hdf5Image, DamageUnderASoundSealNeverCrashes) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "libhdf5 frees uninitialised pointers of a damaged link table";
#endif
  // No accident seals damaged bytes, but HDF5 must then end in an error or in some artifact.
  constexpr int kTries = 3000;
  const auto file = to_hdf5(varied_artifact(), test_label());
  ASSERT_FALSE(is_refused(resealed(file, [](auto&) {})));
  std::mt19937 random(1);
  int refused = 0;
  for (int i = 0; i < kTries; ++i) {
    refused += is_refused(resealed(file, [&](auto& bytes) {
      bytes[random() % bytes.size()] ^= std::byte(1 << (random() % 8));
    }));
  }
  EXPECT_GT(refused, 0);
}

TEST(Hdf5Image, ForeignFilesAreRefused) {
  EXPECT_TRUE(is_refused({}));
  for (const char* text :
       {"hello", "\x89HDF\r\n\x1a\n and some more that is no HDF5 at all......"}) {
    EXPECT_TRUE(is_refused(std::as_bytes(std::span(text, std::strlen(text)))));
  }
  const auto sealed_text =
      resealed(to_hdf5({}, test_label()), [](auto& bytes) { bytes.assign(100, std::byte{'x'}); });
  EXPECT_TRUE(is_refused(sealed_text));
}

}  // namespace
}  // namespace prt
