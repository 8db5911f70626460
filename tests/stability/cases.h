// What the stiff and extreme cases share: their table, their rooms and how well a room is baked.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "stability/small_bake.h"
#include "statistical/test_scenes.h"
#include "transport/direct.h"

namespace prt::test {

/// A line of the table in results/stability.md, where PRT_STABILITY_TABLE names a file. After a
/// failure all further lines of the same test say no.
inline void record(const std::string& what, const std::string& expected, const std::string& found) {
  if (const char* file = std::getenv("PRT_STABILITY_TABLE")) {
    const bool good = !::testing::Test::HasFailure();
    std::ofstream(file, std::ios::app)
        << fmt::format("| {} | {} | {} | {} |\n", what, expected, found, good ? "yes" : "**no**");
  }
}

/// Returns the largest irradiance; fails on what no light can be.
inline double expect_sound(const SampleIrradiance& irradiance, const std::string& what) {
  EXPECT_TRUE(irradiance.direct.allFinite()) << what;
  EXPECT_TRUE(irradiance.indirect.allFinite()) << what;
  EXPECT_GE(irradiance.direct.minCoeff(), 0.0F) << what;
  return std::max(irradiance.direct.maxCoeff(), irradiance.indirect.maxCoeff());
}

inline Scene box(const Vec3f& size, float albedo) {
  Scene scene;
  add_box(scene, -0.5F * size, 0.5F * size, add_material(scene, Vec3f::Constant(albedo)));
  finish(scene);
  return scene;
}

inline Scene furnished() {
  Scene scene = box({4.0F, 2.5F, 3.0F}, 0.6F);
  const auto red = add_material(scene, {0.8F, 0.3F, 0.2F});
  add_box(scene, {0.9F, -0.2F, 0.6F}, {0.3F, -1.25F, 0.1F},
          red);  // corners swapped: faces outwards
  add_quad(scene, {-1.5F, -0.6F, -1.0F}, {0, 0, 1.6F}, {1.2F, 0, 0}, red);
  finish(scene);
  return scene;
}

/// What a bake makes of twelve lights, whatever its unit: relative error of direct light against
/// exact shadows, and indirect flux over direct flux.
struct Quality {
  double direct_error = 0.0;
  double gain = 0.0;
};

inline Quality quality(const Scene& scene, float scale, const Vec3f& offset) {
  const SmallBake bake(scene);
  std::vector<Vec3f> lights;
  for (int i = 0; i < 12; ++i) {
    const auto at = [&](int k) { return 0.15F * static_cast<float>((i * k) % 7 - 3); };
    lights.emplace_back(scale * Vec3f(2.5F * at(3), at(5) + 0.4F, 2.0F * at(2)) + offset);
  }
  const SampleSet& samples = bake.samples();
  const MatrixF exact = direct_irradiance(bake.scene(), bake.bake().caster(), samples, 0,
                                          static_cast<std::uint32_t>(samples.size()), lights, 0.0F);
  double off = 0.0, power = 0.0, sent = 0.0, received = 0.0;
  for (std::size_t l = 0; l < lights.size(); ++l) {
    const SampleIrradiance lit = bake.light(lights[l]);
    expect_sound(lit, "quality");
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const auto i = static_cast<Eigen::Index>(s);
      const double e = exact(static_cast<Eigen::Index>(l), i);
      off += samples.areas[s] * std::pow(lit.direct(i, 0) - e, 2);
      power += samples.areas[s] * e * e;
    }
    sent += bake.flux(lit.direct);
    received += bake.flux(lit.indirect);
  }
  return {std::sqrt(off / power), received / sent};
}

/// The quality's own row, beside one that it should be like.
inline void expect_alike(const std::string& what, const Quality& one, const Quality& other) {
  // Other samples are drawn, so neither is the same number.
  EXPECT_NEAR(other.direct_error, one.direct_error, 0.25 * one.direct_error) << what;
  EXPECT_NEAR(other.gain, one.gain, 0.02 * one.gain) << what;
  record(what,
         fmt::format("direct error {:.1f} % ± a quarter, gain {:.3f} ± 2 %",
                     100.0 * one.direct_error, one.gain),
         fmt::format("{:.1f} %, {:.3f}", 100.0 * other.direct_error, other.gain));
}

}  // namespace prt::test
