// Files with random bits flipped end in a clear error or in a package that can be played.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/log.h"
#include "base/random.h"
#include "package/read.h"
#include "package/write.h"
#include "player/evaluator.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

constexpr int kTries = 200;

Package sound_package(const test::SyntheticRoom& room) {
  Package package = test::synthetic_room(room);
  test::add_near(package);
  test::add_environment(package, 3);
  return package;
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

void play(const Package& package) {
  const Evaluator evaluator(package);
  const std::array<Light, 1> lights{Light{.position = Vec3f(2, 1, 2)}};
  const int order = environment_order(package);
  const MatrixF sky = MatrixF::Ones(3, static_cast<Eigen::Index>(order) * order);
  const SampleIrradiance irradiance = evaluator.evaluate(lights, sky);
  const std::vector<PlayPoint> points(
      5, {package.samples.positions[0], package.samples.normals[0], package.samples.normals[0]});
  EXPECT_EQ(evaluator.reconstruct(irradiance, points).size(), points.size());
}

/// Flips `flips` bits in each of kTries copies within [begin, end) of the file, and counts
/// refusals.
int refused_of_damaged(const std::vector<std::byte>& sound, std::size_t begin, std::size_t end,
                       int flips, const char* stream) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("prt_damage_" + std::to_string(getpid()) + ".prt.glb");
  int refused = 0;
  for (int t = 0; t < kTries; ++t) {
    Random random(stream_key(1, stream), static_cast<std::uint64_t>(t));
    std::vector<std::byte> bytes = sound;
    for (int f = 0; f < flips; ++f) {
      const std::size_t at = begin + random.below(static_cast<std::uint32_t>(end - begin));
      bytes[at] ^= static_cast<std::byte>(1U << random.below(8));
    }
    write_bytes(path, bytes);
    try {
      play(read_package(path));
    } catch (const UserError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      ++refused;
    }
  }
  std::filesystem::remove(path);
  return refused;
}

class Damage : public ::testing::Test {
 protected:
  void SetUp() override { log::set_up(-1); }

  const std::vector<std::byte> sound_ =
      encode_package(sound_package({.samples_per_edge = 4, .directions = 36, .bits = 8}));
  const std::size_t json_bytes_ =
      std::to_integer<std::size_t>(sound_[12]) + 256 * std::to_integer<std::size_t>(sound_[13]);
};

TEST_F(Damage, AnywhereIsRefusedOrPlayable) {
  EXPECT_LT(refused_of_damaged(sound_, 0, sound_.size(), 1, "anywhere"), kTries);
}

TEST_F(Damage, InTheJsonIsMostlyRefused) {
  const int refused = refused_of_damaged(sound_, 0, 20 + json_bytes_, 1, "json");
  EXPECT_GT(refused, kTries / 2);
}

TEST_F(Damage, InManyPlacesIsRefusedOrPlayable) {
  static_cast<void>(refused_of_damaged(sound_, 20 + json_bytes_, sound_.size(), 16, "binary"));
}

}  // namespace
}  // namespace prt
