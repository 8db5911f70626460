// Stiff and extreme scenes, lights and options: each states what must come out. Every case also has
// to be free of NaN, infinity and negative direct light.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/random.h"
#include "bases/depth_basis.h"
#include "bases/pca.h"
#include "stability/cases.h"
#include "statistical/test_scenes.h"

namespace prt {
namespace {

using test::add_box;
using test::add_material;
using test::add_quad;
using test::add_triangle;
using test::box;
using test::expect_alike;
using test::expect_sound;
using test::finish;
using test::furnished;
using test::quality;
using test::Quality;
using test::record;
using test::small_options;
using test::SmallBake;

// Albedo.

/// Light is never lost but by absorption: indirect flux = ρ/(1 − ρ) of the direct flux.
void expect_series_sum(const std::string& solver, float albedo, double tolerance) {
  OptionValues options = small_options();
  options.set("lb.solver", solver);
  const SmallBake room(box({2.0F, 2.0F, 2.0F}, albedo), options);
  const SampleIrradiance lit = room.light(Vec3f(0.2F, -0.1F, 0.3F));
  expect_sound(lit, solver);
  const double gain = room.flux(lit.indirect) / room.flux(lit.direct);
  const double expected = albedo / (1.0 - static_cast<double>(albedo));
  EXPECT_NEAR(gain, expected, tolerance * std::max(expected, 1e-3)) << solver << " " << albedo;
  record(fmt::format("closed room of albedo {}, {}", albedo, solver),
         fmt::format("gain {:.4g} ± {:.2g} %", expected, 100.0 * tolerance),
         fmt::format("{:.4g}", gain));
}

TEST(Stiff, GatherSumsAllBouncesUpToAlbedo0999) {
  for (const float albedo : {0.0F, 0.05F, 0.9F, 0.99F, 0.999F}) {
    expect_series_sum("gather", albedo, 0.03);
  }
}

TEST(Stiff, NearTransferLosesNoBounce) {
  OptionValues options = small_options();
  options.set("rays.directions", 2016);
  options.set("samples.count", 600);
  const SmallBake room(box({2.0F, 2.0F, 2.0F}, 0.9F), options);
  ASSERT_TRUE(room.package().operators.contains("near"));
  const SampleIrradiance lit = room.light(Vec3f(0.2F, -0.1F, 0.3F));
  expect_sound(lit, "near");
  const double gain = room.flux(lit.indirect) / room.flux(lit.direct);
  EXPECT_NEAR(gain, 9.0, 0.27);
  record("closed room of albedo 0.9, with near transfer", "gain 9 ± 3 %",
         fmt::format("{:.4g}", gain));
}

TEST(Stiff, PhotonsSumAllBouncesUpToAlbedo0999) {
  for (const float albedo : {0.0F, 0.9F, 0.99F, 0.999F}) expect_series_sum("photons", albedo, 0.05);
}

TEST(Stiff, AlbedoOneInAClosedRoomIsRefusedOrBounded) {
  for (const std::string solver : {"gather", "photons"}) {
    OptionValues options = small_options();
    options.set("lb.solver", solver);
    std::string said;
    try {
      const SmallBake room(box({2.0F, 2.0F, 2.0F}, 1.0F), options);
    } catch (const UserError& e) {  // exit code 2
      said = e.what();
    }
    EXPECT_NE(said.find("set transport.bounces"), std::string::npos) << solver << ": " << said;
    record("closed room of albedo 1, " + solver, "refused with a reason",
           said.empty() ? "baked" : "refused");
    options.set("transport.bounces", 4);
    const SmallBake bounded(box({2.0F, 2.0F, 2.0F}, 1.0F), options);
    const SampleIrradiance lit = bounded.light(Vec3f(0.2F, -0.1F, 0.3F));
    expect_sound(lit, solver);
    const double gain = bounded.flux(lit.indirect) / bounded.flux(lit.direct);
    EXPECT_NEAR(gain, 4.0, 0.2) << solver;  // four bounces hand on all light, the fifth none
    record("... with transport.bounces 4, " + solver, "gain 4 ± 5 %", fmt::format("{:.3f}", gain));
  }
}

// Depth.

TEST(Stiff, DepthsFrom1e4To1e6InOneCluster) {
  // Rows as a cluster has them: some rays end at a contact, some at the horizon, some escape.
  constexpr Eigen::Index kSamples = 120;
  constexpr Eigen::Index kRays = 256;
  constexpr float kBound = 1e6F;
  MatrixF z(kSamples, kRays);
  for (Eigen::Index s = 0; s < kSamples; ++s) {
    for (Eigen::Index d = 0; d < kRays; ++d) {
      Random random(5, static_cast<std::uint64_t>(s * kRays + d));
      const float t = std::pow(10.0F, -4.0F + 10.0F * random.uniform());
      z(s, d) = unpack_depth(pack_depth(t, kBound, random.uniform() < 0.2F));
    }
  }
  const PrincipalComponents pca = principal_components(z, 119);
  EXPECT_LT(pca.defect, 1e-5);
  const MatrixF again = (pca.coefficients * pca.basis).rowwise() + pca.mean.transpose();
  const float off = (again - z).cwiseAbs().maxCoeff();
  EXPECT_LT(off, 1e-5F);  // 119 components of 120 rows lose nothing
  record("depths from 1e-4 to 1e6 m in one cluster, rank 119", "orthonormal and exact to 1e-5",
         fmt::format("defect {:.0e}, off by {:.0e}", pca.defect, off));
  const MatrixF equal = MatrixF::Constant(kSamples, kRays, 0.37F);
  const PrincipalComponents flat = principal_components(equal, 50);
  EXPECT_EQ(flat.basis.rows(), 0);
  EXPECT_LT((flat.mean.array() - 0.37F).abs().maxCoeff(), 1e-6F);
  record("all depths equal", "rank 0, the mean alone", fmt::format("rank {}", flat.basis.rows()));
}

TEST(Stiff, NothingToHit) {
  Scene scene;
  add_quad(scene, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, add_material(scene, Vec3f::Constant(0.5F)));
  finish(scene);
  const SmallBake bake(std::move(scene));
  const SampleIrradiance lit = bake.light(Vec3f(0, 1, 0));
  expect_sound(lit, "one plane");
  EXPECT_LE(lit.indirect.cwiseAbs().maxCoeff(), 1e-6F * lit.direct.maxCoeff());
  // E = cosθ / r² with nothing in between.
  const SampleSet& samples = bake.samples();
  double worst = 0.0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    if (samples.normals[s].y() < 0.0F) continue;
    const double r = (Vec3f(0, 1, 0) - samples.positions[s]).norm();
    worst =
        std::max(worst, std::abs(lit.direct(static_cast<Eigen::Index>(s), 0) * r * r * r - 1.0));
  }
  EXPECT_LT(worst, 1e-5);  // a dozen float operations
  record("one plane: all rays escape", "E = cosθ/r², no indirect light",
         fmt::format("off by {:.1e}", worst));
}

// Clusters.

TEST(Stiff, ClustersOfAFewSamples) {
  for (const auto& [count, size] : {std::pair{60, 8}, {400, 8}, {1200, 1200}}) {
    OptionValues options = small_options();
    options.set("samples.count", count);
    options.set("samples.cluster_size", size);
    options.set("rays.directions", 64);
    const SmallBake bake(box({2.0F, 2.0F, 2.0F}, 0.5F), options);
    std::uint32_t least = ~0U;
    std::uint32_t most = 0;
    for (std::size_t c = 0; c < bake.samples().clusters(); ++c) {
      least = std::min(least, bake.samples().cluster_size(c));
      most = std::max(most, bake.samples().cluster_size(c));
    }
    const SampleIrradiance lit = bake.light(Vec3f(0.2F, -0.1F, 0.3F));
    expect_sound(lit, "clusters");
    const double gain = bake.flux(lit.indirect) / bake.flux(lit.direct);
    EXPECT_NEAR(gain, 1.0, 0.1);
    record(fmt::format("{} samples in clusters of {} to {}", count, least, most), "gain 1 ± 10 %",
           fmt::format("{:.3f}", gain));
  }
}

TEST(Stiff, TwentyThousandSamplesInOneCluster) {
  Scene scene;
  add_quad(scene, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, add_material(scene, Vec3f::Constant(0.5F)));
  add_quad(scene, {-0.5F, 0.5F, -0.5F}, {1, 0, 0}, {0, 0, 1}, 0);
  finish(scene);
  OptionValues options = small_options();
  options.set("samples.count", 25000);
  options.set("samples.cluster_size", 100000);
  options.set("rays.directions", 64);
  const SmallBake bake(std::move(scene), options);
  std::uint32_t most = 0;
  for (std::size_t c = 0; c < bake.samples().clusters(); ++c) {
    most = std::max(most, bake.samples().cluster_size(c));
  }
  EXPECT_GE(most, 15000U);
  const double largest = expect_sound(bake.light(Vec3f(0.7F, 0.4F, 0.1F)), "one cluster");
  EXPECT_GT(largest, 0.0);
  record(fmt::format("{} samples in one cluster", most), "sound, lit",
         fmt::format("{:.2g} W/m² at most", largest));
}

// Scale.

Scene scaled(Scene scene, float factor) {
  for (Vec3f& p : scene.positions) p *= factor;
  finish(scene);
  return scene;
}

TEST(Scale, ByPowersOfTwoChangesNoBit) {
  OptionValues options = small_options();
  options.set("samples.start", nlohmann::json::array({0.1, 0.9, -0.2}));
  const SmallBake one(furnished(), options);
  for (const int power : {-13, -7, 7, 17}) {
    const float factor = std::ldexp(1.0F, power);
    options.set("samples.start",
                nlohmann::json::array(
                    {double{0.1F * factor}, double{0.9F * factor}, double{-0.2F * factor}}));
    const SmallBake other(scaled(furnished(), factor), options);
    ASSERT_EQ(one.samples().size(), other.samples().size()) << power;
    std::size_t moved = 0;
    for (std::size_t s = 0; s < one.samples().size(); ++s) {
      moved += (one.samples().positions[s] * factor != other.samples().positions[s]) ? 1 : 0;
    }
    EXPECT_EQ(moved, 0U) << power;
    const SampleIrradiance a = one.light(Vec3f(0.2F, 0.5F, 0.3F));
    const SampleIrradiance b = other.light(Vec3f(0.2F, 0.5F, 0.3F) * factor);
    const float square = factor * factor;
    EXPECT_EQ((a.direct - b.direct * square).cwiseAbs().maxCoeff(), 0.0F) << power;
    EXPECT_EQ((a.indirect - b.indirect * square).cwiseAbs().maxCoeff(), 0.0F) << power;
    record(fmt::format("scene scaled by 2^{}", power), "same samples and light, bit for bit",
           fmt::format("{} samples moved", moved));
  }
}

TEST(Scale, OtherFactorsChangeLittle) {
  const Quality one = quality(furnished(), 1.0F, Vec3f::Zero());
  EXPECT_LT(one.direct_error, 0.15);
  for (const float factor : {1e-4F, 1e5F}) {
    expect_alike(fmt::format("scene scaled by {:.0e}", factor), one,
                 quality(scaled(furnished(), factor), factor, Vec3f::Zero()));
  }
}

// Lights.

TEST(Lights, PlacesWhereNoneShouldStand) {
  const SmallBake room(furnished());
  const Vec3f sample = room.samples().positions[17];
  const Vec3f normal = room.samples().normals[17];
  const float edge = 4.0F;
  const std::vector<std::pair<std::string, Vec3f>> places = {
      {"1e-5 m from a surface", sample + 1e-5F * normal},
      {"at a sample", sample},
      {"inside a solid", Vec3f(0.6F, -0.8F, 0.3F)},
      {"outside the room", Vec3f(edge, 0, 0)},
      {"1e5 m away", Vec3f(1e5F, 1e4F, 0)}};
  for (const auto& [where, position] : places) {
    const double largest = expect_sound(room.light(position), where);
    record("light " + where, "finite, not negative", fmt::format("{:.2g} W/m² at most", largest));
  }
}

TEST(Lights, PowersAreLinearOver24Orders) {
  const SmallBake room(furnished());
  Light light;
  light.position = Vec3f(0.2F, 0.5F, 0.3F);
  const SampleIrradiance one = room.light(light);
  for (const float power : {1e-12F, 1e12F}) {
    light.intensity = Vec3f(power, 0.0F, power);
    const SampleIrradiance other = room.light(light);
    expect_sound(other, "power");
    const double off = ((other.indirect.col(0) / power - one.indirect.col(0)).norm() +
                        (other.direct.col(0) / power - one.direct.col(0)).norm()) /
                       (one.indirect.col(0).norm() + one.direct.col(0).norm());
    EXPECT_LT(off, 1e-5);
    EXPECT_EQ(other.direct.col(1).cwiseAbs().maxCoeff(), 0.0F);
    EXPECT_EQ(other.indirect.col(1).cwiseAbs().maxCoeff(), 0.0F);
    record(fmt::format("power {:.0e} W/sr, saturated colour", power), "linear to 1e-5",
           fmt::format("{:.1e}", off));
  }
}

// Geometry.

TEST(Geometry, TwoRoomsJoinedByAPinhole) {
  // A wall across the room with a hole of 1 cm.
  Scene scene = box({4.0F, 2.0F, 2.0F}, 0.8F);
  const float h = 0.005F;
  for (const float x : {-0.002F, 0.002F}) {
    add_quad(scene, {x, -1, -1}, {0, 1 - h, 0}, {0, 0, 2}, 0);
    add_quad(scene, {x, h, -1}, {0, 1 - h, 0}, {0, 0, 2}, 0);
    add_quad(scene, {x, -h, -1}, {0, 2 * h, 0}, {0, 0, 1 - h}, 0);
    add_quad(scene, {x, -h, h}, {0, 2 * h, 0}, {0, 0, 1 - h}, 0);
  }
  finish(scene);
  const SmallBake bake(std::move(scene));
  const SampleIrradiance lit = bake.light(Vec3f(-1.2F, 0.3F, 0.2F));
  expect_sound(lit, "pinhole");
  const auto left = [](const Vec3f& p, const Vec3f&) { return p.x() < -0.001F; };
  const auto right = [](const Vec3f& p, const Vec3f&) { return p.x() > 0.001F; };
  const MatrixF all = lit.direct + lit.indirect;
  const double bright = bake.mean(all, left);
  const double dark = bake.mean(all, right);
  const double share = dark / bright;
  // A part in 240,000 of the bright room's surface is hole, and the dark room keeps 0.8 of what it
  // gets: 2e-5 of the bright room's light. Transfer is compressed to 1 % of a cluster's own light,
  // in the mean over lights, so what is left there is rounding.
  EXPECT_LT(std::abs(share), 2e-3);
  record("two rooms joined by a pinhole", "dark room below 0.2 % of the other (2e-5 is true)",
         fmt::format("{:.1e}", share));
}

/// A wall of 1 mm parts most of the room; the light stands just behind it.
Scene parted_room() {
  Scene scene = box({4.0F, 2.0F, 4.0F}, 0.5F);
  add_quad(scene, {-0.0005F, -1, -2}, {0, 2, 0}, {0, 0, 3.4F}, 0);
  add_quad(scene, {0.0005F, -1, -2}, {0, 2, 0}, {0, 0, 3.4F}, 0);
  add_quad(scene, {-0.0005F, -1, 1.4F}, {0.001F, 0, 0}, {0, 2, 0}, 0);
  finish(scene);
  return scene;
}

/// Direct light that the player shows on the floor, in the mean of places between `from` and `to`
/// metres from the wall, none of them near its end.
double floor_light(const SmallBake& bake, const SampleIrradiance& lit, float from, float to) {
  constexpr int kAcross = 10;
  constexpr int kAlong = 20;
  std::vector<PlayPoint> points;
  for (int i = 0; i < kAcross; ++i) {
    for (int k = 0; k < kAlong; ++k) {
      const float x = from + (to - from) * (static_cast<float>(i) + 0.5F) / kAcross;
      const Vec3f up(0, 1, 0);
      points.push_back({{x, -1, -1.8F + 1.6F * static_cast<float>(k) / kAlong}, up, up});
    }
  }
  double sum = 0.0;
  for (const auto& p : bake.player().reconstruct(lit, points)) sum += p.direct.x();
  return sum / static_cast<double>(points.size());
}

TEST(Geometry, LightLeaksThroughThinWallsNoFartherThanSplatsReach) {
  for (const int count : {3000, 12000}) {
    OptionValues options = small_options();
    options.set("samples.count", count);
    options.set("rays.directions", 504);
    const SmallBake bake(parted_room(), options);
    const SampleIrradiance lit = bake.light(Vec3f(-0.3F, 0.0F, -1.0F));
    expect_sound(lit, "thin wall");
    // No surface tells the floor's two sides apart, so a splat may lie across the wall.
    const float spacing = std::sqrt(64.0F / static_cast<float>(count));
    const double bright = floor_light(bake, lit, -0.5F, 0.0F);
    const double beside = floor_light(bake, lit, 0.0005F, spacing) / bright;
    const double beyond = floor_light(bake, lit, 2.0F * spacing, 0.7F) / bright;
    EXPECT_GT(bright, 0.0);
    EXPECT_LT(beyond, 0.002) << count;
    record(fmt::format("wall of 1 mm, samples every {:.2f} m", spacing),
           "leak below 0.2 % of the light behind it, two samples from it",
           fmt::format("{:.2f} % there, {:.1f} % beside it", 100.0 * beyond, 100.0 * beside));
  }
}

Scene odd(const std::string& name) {
  Scene scene;
  const auto white = add_material(scene, Vec3f::Constant(0.7F));
  if (name == "single triangle") {
    add_triangle(scene, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, white);
  } else if (name == "coplanar faces") {
    for (int i = 0; i < 3; ++i) add_quad(scene, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, white);
    add_quad(scene, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, white);
  } else if (name == "inverted normals") {
    add_box(scene, {1, 1, 1}, {-1, -1, -1}, white);
  } else if (name == "open mesh") {
    add_quad(scene, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, white);
    add_quad(scene, {-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, white);
  } else if (name == "slivers") {
    for (int i = 0; i < 200; ++i) {
      const float x = 0.01F * static_cast<float>(i);
      add_triangle(scene, {x, 0, 0}, {x, 0, 2}, {x + 0.01F, 0, 1e-3F}, white);
      add_triangle(scene, {x, 0, 2}, {x + 0.01F, 0, 2}, {x + 0.01F, 0, 1e-3F}, white);
    }
    add_quad(scene, {0, 1, 0}, {2, 0, 0}, {0, 0, 2}, white);
  } else if (name == "fan") {
    for (int i = 0; i < 400; ++i) {
      const auto at = [](int k) {
        const float a = 6.2831853F * static_cast<float>(k) / 400.0F;
        return Vec3f(std::cos(a), 0, std::sin(a));
      };
      add_triangle(scene, Vec3f::Zero(), at(i + 1), at(i), white);
    }
  }
  finish(scene);
  return scene;
}

TEST(Geometry, OddMeshesBake) {
  for (const std::string name :
       {"single triangle", "coplanar faces", "inverted normals", "open mesh", "slivers", "fan"}) {
    SCOPED_TRACE(name);
    OptionValues options = small_options();
    options.set("samples.count", 400);
    const SmallBake bake(odd(name), options);
    // A box that is turned inside out is solid: the side that sampling began at is lit.
    const float x = name == "inverted normals" ? -3.31F : 0.31F;
    const SampleIrradiance lit = bake.light(Vec3f(x, 0.5F, 0.22F));
    const double largest = expect_sound(lit, name);
    EXPECT_GT(largest, 0.0);
    record(name, "bakes, sound, lit", fmt::format("{:.2g} W/m² at most", largest));
  }
}

// Nothing needless.

TEST(Needless, BlackSurfacesHaveNoTransport) {
  const SmallBake room(box({2, 2, 2}, 0.0F));
  EXPECT_TRUE(room.package().operators.empty());
  EXPECT_FALSE(room.plan().left_out.empty());
}

}  // namespace
}  // namespace prt
