// Linear pictures: what they hold, and the OpenEXR file that keeps them.
#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "base/image_file.h"
#include "player/picture.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

/// Reads a file as the OpenEXR specification lays it out.
class ExrReader {
 public:
  explicit ExrReader(const std::string& bytes) : bytes_(bytes) {
    EXPECT_EQ(take<std::uint32_t>(), 20000630U);
    EXPECT_EQ(take<std::uint32_t>(), 2U);
    for (std::string called = text(); !called.empty(); called = text()) {
      static_cast<void>(text());  // its type
      const auto size = take<std::uint32_t>();
      attributes[called] = bytes_.substr(at_, size);
      at_ += size;
    }
  }
  template <typename T>
  T take() {
    T value;
    EXPECT_LE(at_ + sizeof value, bytes_.size());
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string text() {
    const std::string found(bytes_.data() + at_);
    at_ += found.size() + 1;
    return found;
  }
  [[nodiscard]] std::size_t at() const { return at_; }
  std::map<std::string, std::string> attributes;

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

TEST(Exr, HoldsThePicturesLinesChannelByChannel) {
  constexpr int kWidth = 3;
  constexpr int kHeight = 2;
  std::vector<float> rgb;
  for (int i = 0; i < 3 * kWidth * kHeight; ++i) rgb.push_back(0.25F * static_cast<float>(i - 4));
  const std::string bytes = encode_exr(kWidth, kHeight, rgb);
  ExrReader file(bytes);
  for (const char* required :
       {"channels", "compression", "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
        "screenWindowCenter", "screenWindowWidth"}) {
    EXPECT_TRUE(file.attributes.contains(required)) << required;
  }
  EXPECT_EQ(file.attributes["channels"].size(), 55U);
  EXPECT_EQ(file.attributes["channels"].substr(0, 2), std::string("B\0", 2));
  EXPECT_EQ(file.attributes["dataWindow"], std::string("\0\0\0\0\0\0\0\0\2\0\0\0\1\0\0\0", 16));
  std::vector<std::uint64_t> offsets;
  for (int y = 0; y < kHeight; ++y) offsets.push_back(file.take<std::uint64_t>());
  for (int y = 0; y < kHeight; ++y) {
    EXPECT_EQ(offsets[static_cast<std::size_t>(y)], file.at());
    EXPECT_EQ(file.take<std::int32_t>(), y);
    EXPECT_EQ(file.take<std::uint32_t>(), 4U * 3U * kWidth);
    for (const int channel : {2, 1, 0}) {
      for (int x = 0; x < kWidth; ++x) {
        const auto i = static_cast<std::size_t>(3 * (y * kWidth + x) + channel);
        EXPECT_EQ(file.take<float>(), rgb[i]);
      }
    }
  }
  EXPECT_EQ(file.at(), bytes.size());
}

/// The middle pixel's place on the wall is off by float rounding, over which light hardly changes.
constexpr float kRelative = 1e-3F;

TEST(LinearPicture, IsRadianceWhateverTheExposure) {
  const Package room = test::synthetic_room({.directions = 0});
  const Evaluator player(room);
  const Light light{.position = {2.0F, 1.5F, 2.5F}, .intensity = {9, 6, 3}};
  const SampleIrradiance irradiance = player.evaluate({&light, 1});
  SceneCamera camera;
  camera.eye = {2.0F, 1.5F, 1.0F};
  camera.target = {3.2F, 1.0F, 5.0F};  // past the leaf in the middle of the room
  constexpr int kWidth = 41;
  constexpr int kHeight = 31;
  const auto picture = [&](float exposure, Show show) {
    return render(
        player, irradiance, camera,
        {.width = kWidth, .height = kHeight, .show = show, .exposure = exposure, .linear = true});
  };
  const Picture once = picture(1.0F, Show::kFull);
  EXPECT_TRUE(once.rgb.empty());
  ASSERT_EQ(once.radiance.size(), std::size_t{3} * kWidth * kHeight);
  EXPECT_EQ(once.radiance, picture(7.0F, Show::kFull).radiance);
  // The middle pixel looks at the far wall.
  const Vec3f view = camera.target - camera.eye;
  const Vec3f seen = camera.eye + view * (4.0F / view.z());
  const auto played = player.reconstruct(
      irradiance, std::vector<PlayPoint>{{seen, -Vec3f::UnitZ(), -Vec3f::UnitZ()}});
  const Vec3f albedo = room.scene.materials[0].base_color;
  const Picture direct = picture(1.0F, Show::kDirect);
  for (int c = 0; c < 3; ++c) {
    const auto at = static_cast<std::size_t>(3 * ((kHeight / 2) * kWidth + kWidth / 2) + c);
    const float expected = albedo[c] / kPi * (played[0].direct[c] + played[0].indirect[c]);
    EXPECT_NEAR(once.radiance[at], expected, kRelative * expected);
    const float first = albedo[c] / kPi * played[0].direct[c];
    EXPECT_NEAR(direct.radiance[at], first, kRelative * first);
  }
}

}  // namespace
}  // namespace prt
