// Stiff and extreme scenes, lights and options: each states what must come out. Every case also has
// to be free of NaN, infinity and negative direct light.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "base/error.h"
#include "base/random.h"
#include "bases/depth_basis.h"
#include "bases/pca.h"
#include "stability/small_bake.h"
#include "statistical/test_scenes.h"
#include "transport/direct.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

using test::add_box;
using test::add_material;
using test::add_quad;
using test::add_triangle;
using test::finish;
using test::small_options;
using test::SmallBake;

/// A line of the table in results/stability.md, where PRT_STABILITY_TABLE names a file. After a
/// failure all further lines of the same test say no.
void record(const std::string& what, const std::string& expected, const std::string& found) {
  if (const char* file = std::getenv("PRT_STABILITY_TABLE")) {
    const bool good = !::testing::Test::HasFailure();
    std::ofstream(file, std::ios::app)
        << fmt::format("| {} | {} | {} | {} |\n", what, expected, found, good ? "yes" : "**no**");
  }
}

/// Returns the largest irradiance; fails on what no light can be.
double expect_sound(const SampleIrradiance& irradiance, const std::string& what) {
  EXPECT_TRUE(irradiance.direct.allFinite()) << what;
  EXPECT_TRUE(irradiance.indirect.allFinite()) << what;
  EXPECT_GE(irradiance.direct.minCoeff(), 0.0F) << what;
  return std::max(irradiance.direct.maxCoeff(), irradiance.indirect.maxCoeff());
}

Scene box(const Vec3f& size, float albedo) {
  Scene scene;
  add_box(scene, -0.5F * size, 0.5F * size, add_material(scene, Vec3f::Constant(albedo)));
  finish(scene);
  return scene;
}

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

Scene furnished() {
  Scene scene = box({4.0F, 2.5F, 3.0F}, 0.6F);
  const auto red = add_material(scene, {0.8F, 0.3F, 0.2F});
  add_box(scene, {0.9F, -0.2F, 0.6F}, {0.3F, -1.25F, 0.1F},
          red);  // corners swapped: faces outwards
  add_quad(scene, {-1.5F, -0.6F, -1.0F}, {0, 0, 1.6F}, {1.2F, 0, 0}, red);
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

/// What a bake makes of twelve lights, whatever its unit: relative error of direct light against
/// exact shadows, and indirect flux over direct flux.
struct Quality {
  double direct_error = 0.0;
  double gain = 0.0;
};

Quality quality(const Scene& scene, float scale, const Vec3f& offset) {
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
void expect_alike(const std::string& what, const Quality& one, const Quality& other) {
  // Other samples are drawn, so neither is the same number.
  EXPECT_NEAR(other.direct_error, one.direct_error, 0.25 * one.direct_error) << what;
  EXPECT_NEAR(other.gain, one.gain, 0.02 * one.gain) << what;
  record(what,
         fmt::format("direct error {:.1f} % ± a quarter, gain {:.3f} ± 2 %",
                     100.0 * one.direct_error, one.gain),
         fmt::format("{:.1f} %, {:.3f}", 100.0 * other.direct_error, other.gain));
}

TEST(Scale, OtherFactorsChangeLittle) {
  const Quality one = quality(furnished(), 1.0F, Vec3f::Zero());
  EXPECT_LT(one.direct_error, 0.15);
  for (const float factor : {1e-4F, 1e5F}) {
    expect_alike(fmt::format("scene scaled by {:.0e}", factor), one,
                 quality(scaled(furnished(), factor), factor, Vec3f::Zero()));
  }
}

// Far places.

/// The scene written to a file and loaded again, with its vertices and its node moved.
Scene through_file(const Scene& scene, const Vec3f& vertices, const Vec3d& node) {
  testing::GltfWriter writer;
  for (std::uint32_t m = 0; m < scene.materials.size(); ++m) {
    std::vector<float> positions;
    for (const Triangle& triangle : scene.triangles) {
      if (triangle.material != m) continue;
      for (const std::uint32_t v : triangle.vertex) {
        const Vec3f p = scene.positions[v] + vertices;
        positions.insert(positions.end(), p.data(), p.data() + 3);
      }
    }
    const Vec3f& albedo = scene.materials[m].base_color;
    const auto material = writer.append(
        "materials", {{"pbrMetallicRoughness",
                       {{"baseColorFactor", {albedo.x(), albedo.y(), albedo.z(), 1.0}}}}});
    writer.add_mesh_node({{"attributes", {{"POSITION", writer.add_accessor(positions, "VEC3")}}},
                          {"material", material}},
                         {{"translation", {node.x(), node.y(), node.z()}}});
  }
  return writer.load();
}

TEST(FarPlaces, ThroughANodeNoBitChanges) {
  const Scene home = through_file(furnished(), Vec3f::Zero(), Vec3d::Zero());
  const SmallBake one(home);
  for (const Vec3d& move : {Vec3d(1e5, 2e4, -1e5), Vec3d(1e9, 0, 0)}) {
    const Scene far = through_file(furnished(), Vec3f::Zero(), move);
    EXPECT_EQ(far.origin, move);
    const SmallBake other(far);
    ASSERT_EQ(one.samples().size(), other.samples().size());
    std::size_t moved = 0;
    for (std::size_t s = 0; s < one.samples().size(); ++s) {
      moved += (one.samples().positions[s] != other.samples().positions[s]) ? 1 : 0;
    }
    EXPECT_EQ(moved, 0U);
    const Vec3f place(0.2F, 0.5F, 0.3F);
    const SampleIrradiance a = one.light(place);
    const SampleIrradiance b = other.light(relative_to(far.origin, move + place.cast<double>()));
    expect_sound(b, "far");
    EXPECT_LT((a.direct - b.direct).cwiseAbs().maxCoeff(), 1e-5F * a.direct.maxCoeff());
    EXPECT_LT((a.indirect - b.indirect).cwiseAbs().maxCoeff(), 1e-5F * a.indirect.maxCoeff());
    record(fmt::format("scene of 5 m moved by {:.0e} m through a node", move.x()),
           "same samples bit for bit, same light to 1e-5", fmt::format("{} samples moved", moved));
  }
}

TEST(FarPlaces, InItsVerticesTheFilesOwnRoundingIsLeft) {
  const Quality one = quality(furnished(), 1.0F, Vec3f::Zero());
  for (const float metres : {1e4F, 1e5F}) {
    const Vec3f move(metres, 0.2F * metres, -metres);
    const Scene far = through_file(furnished(), move, Vec3d::Zero());
    ASSERT_FALSE(far.repairs.notes.empty());
    EXPECT_NE(far.repairs.notes.back().find("good to"), std::string::npos);
    expect_alike(
        fmt::format("scene of 5 m stored {:.0e} m from its mesh's origin, vertices good to "
                    "{:.2g} mm, which is said",
                    metres, 1e3 * far.vertex_rounding),
        one, quality(far, 1.0F, relative_to(far.origin, move.cast<double>())));
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
