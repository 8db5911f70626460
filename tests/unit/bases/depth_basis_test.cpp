#include "bases/depth_basis.h"

#include <gtest/gtest.h>

#include <vector>

namespace prt {
namespace {

constexpr float kBound = 7.0F;

TEST(DepthBasis, EncodesTheRootOfTheShareOfTheBound) {
  EXPECT_EQ(encode_depth(0.0F, kBound), 0.0F);
  EXPECT_EQ(encode_depth(-1.0F, kBound), 0.0F);
  EXPECT_FLOAT_EQ(encode_depth(0.25F * kBound, kBound), 0.5F);
  EXPECT_EQ(encode_depth(kBound, kBound), 1.0F);
  EXPECT_EQ(encode_depth(kInfinity, kBound), 1.0F);
}

TEST(DepthBasis, PackingRoundTripsWithinHalfAStep) {
  // Rounding to nearest of 65535 levels, plus float's own rounding.
  constexpr float kHalfStep = 0.5F / 65534.0F + 1e-7F;
  for (int i = 0; i <= 100000; ++i) {
    const float t = kBound * static_cast<float>(i) / 100000.0F;
    const std::uint16_t packed = pack_depth(t, kBound, false);
    ASSERT_NE(packed, kEscapedDepth);  // a hit never reads as an escape
    ASSERT_NEAR(unpack_depth(packed), encode_depth(t, kBound), kHalfStep);
  }
}

TEST(DepthBasis, EscapeIsAValueOfItsOwn) {
  EXPECT_EQ(pack_depth(kInfinity, kBound, true), kEscapedDepth);
  EXPECT_EQ(unpack_depth(kEscapedDepth), 1.0F);
  EXPECT_EQ(pack_depth(kBound, kBound, false), 65534);
  EXPECT_EQ(unpack_depth(65534), 1.0F);
  EXPECT_EQ(unpack_depth(0), 0.0F);
}

/// A 2 × 2 grid: every direction inside has all four as neighbours.
class DepthVisibility : public ::testing::Test {
 protected:
  [[nodiscard]] float share(const Vec3f& local, float distance, float bias) const {
    return depth_visibility(
        directions_, [&](int i) { return encode_depth(depths_[i], kBound); }, local, distance,
        kBound, bias);
  }
  HemisphereDirections directions_{4};
  std::vector<float> depths_ = {1.0F, 2.0F, 3.0F, kInfinity};
};

TEST_F(DepthVisibility, SumsTheWeightsOfDirectionsThatReachAsFar) {
  // Straight up lies in the middle of the four: a quarter each.
  const Vec3f up = Vec3f::UnitZ();
  EXPECT_NEAR(share(up, 0.5F, 0.0F), 1.0F, 1e-6F);
  EXPECT_NEAR(share(up, 1.5F, 0.0F), 0.75F, 1e-6F);
  EXPECT_NEAR(share(up, 2.5F, 0.0F), 0.5F, 1e-6F);
  EXPECT_NEAR(share(up, 5.0F, 0.0F), 0.25F, 1e-6F);
  EXPECT_NEAR(share(up, kInfinity, 0.0F), 0.25F, 1e-6F);  // only where the ray escaped
}

TEST_F(DepthVisibility, ForgivesTheBias) {
  const Vec3f up = Vec3f::UnitZ();
  EXPECT_NEAR(share(up, 1.05F, 0.0F), 0.75F, 1e-6F);
  EXPECT_NEAR(share(up, 1.05F, 0.07F), 1.0F, 1e-6F);  // 1.05 · 0.93 < 1
  EXPECT_NEAR(share(up, 1.10F, 0.07F), 0.75F, 1e-6F);
}

TEST_F(DepthVisibility, TakesOneDirectionAloneAtItsCentre) {
  for (int i = 0; i < 4; ++i) {
    const Vec3f& d = directions_.direction(i);
    EXPECT_NEAR(share(d, 0.99F * std::min(depths_[i], 6.0F), 0.0F), 1.0F, 1e-5F) << i;
    const float behind = i < 3 ? 0.0F : 1.0F;  // the fourth ray escaped: nothing is behind
    EXPECT_NEAR(share(d, 1.01F * depths_[i], 0.0F), behind, 1e-5F) << i;
  }
}

TEST_F(DepthVisibility, IsNothingFromBelow) {
  EXPECT_EQ(share(-Vec3f::UnitZ(), 0.1F, 0.0F), 0.0F);
  EXPECT_EQ(share(Vec3f::UnitX(), 0.1F, 0.0F), 0.0F);
}

}  // namespace
}  // namespace prt
