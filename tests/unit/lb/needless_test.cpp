// Scenes made for it: what each does without, that it is said, and that the light stays the same.
#include "methods/lb/needless.h"

#include <gtest/gtest.h>

#include "bases/pca.h"
#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/lb/lb.h"
#include "operators/low_rank.h"
#include "package/write.h"
#include "player/evaluator.h"
#include "statistical/test_scenes.h"
#include "store/quantised_io.h"
#include "support/partial_bake.h"
#include "transport/direct.h"

namespace prt {
namespace {

constexpr float kSide = 2.0F;  // m

OptionValues small_bake() {
  OptionValues options = test::default_options(lb_method());
  options.set("samples.count", 400);
  options.set("samples.cluster_size", 60);
  options.set("rays.directions", 144);
  options.set("lb.example_lights", 60);
  options.set("lb.light_rank", 4);
  options.set("samples.start", {0.4F * kSide, 0.6F * kSide, 0.45F * kSide});
  return options;
}

Scene empty_room(float albedo) {
  Scene scene;
  test::add_box(scene, Vec3f::Zero(), Vec3f::Constant(kSide),
                test::add_material(scene, Vec3f::Constant(albedo)));
  test::finish(scene);
  return scene;
}

/// A bake in memory, its plan and its package.
struct Baked {
  Baked(const Scene& scene, const OptionValues& options) : bake(scene, options) {
    plan = bake.run(lb_method());
    package = lb_method().assemble([&](const std::string& id) { return bake.result(id); }, options);
    package.scene = scene;
    validate(package, "the baked room");
  }
  [[nodiscard]] std::size_t count(const std::string& kind) const {
    return std::ranges::count_if(plan.tasks, [&](const TaskSpec& t) { return t.kind == kind; });
  }
  /// Why something was left out; empty if it was not.
  [[nodiscard]] std::string reason(const std::string& what) const {
    for (const LeftOut& l : plan.left_out) {
      if (l.what.starts_with(what)) return l.reason;
    }
    return "";
  }
  [[nodiscard]] const SampleSet& samples() const { return package.samples; }

  test::InProcessBake bake;
  Plan plan;
  Package package;
};

Light point_light(const Vec3f& position) {
  Light light;
  light.position = position;
  return light;
}

std::vector<Light> lights_within(const Vec3f& low, const Vec3f& high) {
  std::vector<Light> lights;
  for (const Vec3f& share : {Vec3f(0.2F, 0.3F, 0.25F), Vec3f(0.7F, 0.8F, 0.4F),
                             Vec3f(0.5F, 0.55F, 0.85F), Vec3f(0.9F, 0.15F, 0.6F)}) {
    lights.push_back(point_light(low + share.cwiseProduct(high - low)));
  }
  return lights;
}

/// ‖a − b‖ / ‖b‖ over the samples, by area.
double relative_difference(const MatrixF& a, const MatrixF& b, const SampleSet& samples) {
  double squared = 0.0, total = 0.0;
  for (Eigen::Index s = 0; s < b.rows(); ++s) {
    squared += samples.areas[s] * (a.row(s) - b.row(s)).cast<double>().squaredNorm();
    total += samples.areas[s] * b.row(s).cast<double>().squaredNorm();
  }
  return std::sqrt(squared / total);
}

TEST(Needless, AnEmptyRoomHasNoVisibilityBasis) {
  const Scene scene = empty_room(0.5F);
  const Baked baked(scene, small_bake());
  for (const DepthBlock& block : baked.package.visibility->clusters) {
    EXPECT_EQ(block.mean.bytes() + block.basis.bytes() + block.coefficients.bytes(), 0U);
    EXPECT_LE(block.walls.rows(), 6);
    EXPECT_GE(block.walls.rows(), 3);
  }
  EXPECT_NE(baked.reason("visibility basis of"), "");
  // Without depths there is no error of depths: direct light is exact.
  const Evaluator evaluator(baked.package);
  for (const Light& light : lights_within(Vec3f::Zero(), Vec3f::Constant(kSide))) {
    const std::vector<Light> one = {light};
    const SampleIrradiance played = evaluator.evaluate(one);
    const MatrixF exact = direct_irradiance(scene, baked.bake.caster(), baked.samples(), 0,
                                            static_cast<std::uint32_t>(baked.samples().size()),
                                            std::vector<Vec3f>{light.position}, 0.0F);
    // The reference leaves a little in front of the surface, which a light near by notices.
    constexpr double kOffset = 2e-4;
    const double off =
        relative_difference(played.direct.leftCols(1), exact.transpose(), baked.samples());
    EXPECT_LT(off, kOffset);
  }
}

TEST(Needless, AClosedRoomHasNoEscapeData) {
  const Baked baked(empty_room(0.5F), small_bake());
  EXPECT_NE(baked.reason("escape data"), "");
  // Not even the sun, which shines wherever a ray escapes, comes in.
  const Evaluator evaluator(baked.package);
  for (const Vec3f& direction :
       {Vec3f(0, -1, 0), Vec3f(0.6F, 0, 0.8F), Vec3f(-0.6F, 0.64F, 0.48F)}) {
    Light sun{.kind = Light::Kind::kSun};
    sun.direction = direction;
    const std::vector<Light> one = {sun};
    const SampleIrradiance played = evaluator.evaluate(one);
    EXPECT_TRUE(played.direct.isZero(0.0F));
    EXPECT_TRUE(played.indirect.isZero(0.0F));
  }
  Scene open = empty_room(0.5F);
  open.triangles.resize(open.triangles.size() - 2);
  EXPECT_EQ(Baked(open, small_bake()).reason("escape data"), "");
}

/// Root mean square of what 8 bits and `rank` functions make of a cluster's depths, and of what
/// they should be.
double depth_error(const Artifact& rays, int rank) {
  const auto packed = rays.values<std::uint16_t>("distance");
  const auto& dims = rays.at("distance").dims;
  MatrixF z(dims[0], dims[1]);
  for (std::size_t i = 0; i < packed.size(); ++i) z.data()[i] = unpack_depth(packed[i]);
  PrincipalComponents pca = principal_components(z, rank);
  balance(pca.coefficients, pca.basis);
  const MatrixF again =
      (quantise(pca.coefficients, 8).matrix.decode() * quantise(pca.basis, 8).matrix.decode())
          .rowwise() +
      quantise(pca.mean.transpose(), 16).matrix.decode().row(0);
  return (again - z).cast<double>().norm() / std::sqrt(static_cast<double>(z.size()));
}

constexpr int kMost = 60;  // visibility functions

TEST(Needless, FlatWallsHaveAsManyFunctionsAsTheirEnergyNeeds) {
  // A speck on the floor keeps the room from being empty; most of what is seen is flat.
  Scene scene = empty_room(0.5F);
  const Vec3f speck(0.5F * kSide, 0.0F, 0.5F * kSide);
  test::add_box(scene, speck + Vec3f::Constant(0.1F), speck - Vec3f(0.1F, 0, 0.1F), 0);
  test::finish(scene);
  OptionValues options = small_bake();
  options.set("samples.count", 4000);
  options.set("lb.visibility_rank", kMost);
  test::InProcessBake bake(scene, options);
  auto kinds = test::kSamplingAndRays;
  kinds.insert("visibility");
  test::run_kinds(bake, lb_method(), kinds);
  const SampleSet samples = test::samples_of(bake);
  std::size_t lower = 0;
  int ranks = 0, full_ranks = 0;
  double squared = 0.0, squared_with_all = 0.0;
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const auto visibility = bake.result(numbered("visibility", c));
    if (visibility->attribute<int>("unoccluded") == 1) continue;
    const int full = std::min(kMost, static_cast<int>(samples.cluster_size(c)) - 1);
    const int rank = visibility->attribute<int>("rank");
    EXPECT_EQ(rank, get_quantised(*visibility, "basis").rows);
    lower += rank < full ? 1 : 0;
    const double with_all = depth_error(*bake.result(numbered("rays", c)), kMost);
    const double weight = samples.cluster_size(c);
    squared += weight * std::pow(visibility->attribute<double>("error"), 2);
    squared_with_all += weight * std::pow(with_all, 2);
    // Where there is room for all functions, what is left out is a tenth of the rounding at most.
    constexpr double kTruncationShare = 0.1;
    if (full < kMost) {
      EXPECT_LE(visibility->attribute<double>("rms_error"), kTruncationShare * with_all) << c;
    }
    ranks += rank;
    full_ranks += full;
  }
  const double more = std::sqrt(squared / squared_with_all);
  std::printf("%d of %d functions: error %.4f times that with all\n", ranks, full_ranks, more);
  // 0.5 % by what is left out; rounding the rest anew scatters by as much.
  EXPECT_LT(more, 1.01);
  EXPECT_GT(lower, samples.clusters() / 2);
  const Plan plan = lb_method().plan(bake);
  EXPECT_TRUE(std::ranges::any_of(plan.left_out, [](const LeftOut& l) {
    return l.what.starts_with("visibility functions") && !l.reason.empty();
  }));
}

TEST(Needless, FewBouncesAreEnoughWhereAllIsDark) {
  struct Case {
    float albedo;
    std::size_t snapshots, galerkin, residual;  ///< tasks per cluster
  };
  for (const Case& c : {Case{0.01F, 0, 0, 0}, Case{0.05F, 1, 0, 0}, Case{0.3F, 1, 1, 1}}) {
    const Scene scene = empty_room(c.albedo);
    OptionValues options = small_bake();
    const Baked baked(scene, options);
    const std::size_t clusters = baked.samples().clusters();
    EXPECT_EQ(baked.count("snapshot"), c.snapshots * clusters) << c.albedo;
    EXPECT_EQ(baked.count("galerkin"), c.galerkin * clusters) << c.albedo;
    EXPECT_EQ(baked.count("residual"), c.residual * clusters) << c.albedo;
    const bool limited = c.residual == 0;
    EXPECT_EQ(baked.reason(c.snapshots == 0 ? "all bounces but" : "bounces after") != "", limited);
    if (!limited) continue;
    options.set("transport.bounces", 30);
    const Baked all(scene, options);
    const auto lights = lights_within(Vec3f::Zero(), Vec3f::Constant(kSide));
    const double off =
        relative_difference(Evaluator(baked.package).evaluate(lights).indirect,
                            Evaluator(all.package).evaluate(lights).indirect, baked.samples());
    std::printf("albedo %.2f: %.4f of the indirect light is left out\n", c.albedo, off);
    EXPECT_LT(off, options.get<double>("transport.tolerance"));
    EXPECT_GT(off, 0.0);
  }
}

TEST(Needless, BouncesAreCountedByTheLargestAlbedo) {
  EXPECT_EQ(lb::sufficient_bounces(0.02, 0.02), 1);
  EXPECT_EQ(lb::sufficient_bounces(0.05, 0.02), 2);
  EXPECT_EQ(lb::sufficient_bounces(0.05, 1e-3), 3);
  EXPECT_EQ(lb::sufficient_bounces(0.5, 0.1), 4);
  EXPECT_GT(lb::sufficient_bounces(1.0, 0.1), 100);
}

TEST(Needless, SealedRoomsExchangeNothing) {
  // Farther apart than clusters reach: a cluster of both rooms would see both.
  constexpr float kGap = 3.0F;
  const Vec3f second(kSide + kGap, 0, 0);
  Scene scene = empty_room(0.7F);
  test::add_box(scene, second, second + Vec3f::Constant(kSide), 0);
  test::finish(scene);
  OptionValues options = small_bake();
  options.set("samples.count", 800);
  const Vec3f inside = Vec3f(0.4F, 0.6F, 0.45F) * kSide;
  const Vec3f inside_too = second + inside;
  options.set("samples.start", {{inside.x(), inside.y(), inside.z()},
                                {inside_too.x(), inside_too.y(), inside_too.z()}});
  const Baked baked(scene, options);
  const SampleSet& samples = baked.samples();
  const auto room_of = [&](std::uint32_t c) {
    return samples.positions[samples.cluster_begin[c]].x() > kSide + 0.5F * kGap ? 1 : 0;
  };
  std::array<std::size_t, 2> clusters{};
  std::size_t kept = 0;
  const auto& transfer = std::get<ClusterTransfer>(baked.package.operators.at("transfer"));
  for (std::uint32_t r = 0; r < samples.clusters(); ++r) {
    for (std::uint32_t s = samples.cluster_begin[r]; s < samples.cluster_begin[r + 1]; ++s) {
      ASSERT_EQ(samples.positions[s].x() > kSide + 0.5F * kGap ? 1 : 0, room_of(r));
    }
    ++clusters[room_of(r)];
    for (const std::uint32_t sender : transfer.receivers[r].senders) {
      EXPECT_EQ(room_of(sender), room_of(r));
    }
    kept += transfer.receivers[r].senders.size();
  }
  EXPECT_GT(clusters[0], 3U);
  EXPECT_GT(clusters[1], 3U);
  EXPECT_EQ(kept, clusters[0] * clusters[0] + clusters[1] * clusters[1]);
  EXPECT_NE(baked.reason("transfer blocks"), "");
  // A light here leaves the other room as dark as it was.
  const auto lights = lights_within(Vec3f::Zero(), Vec3f::Constant(kSide));
  const SampleIrradiance played = Evaluator(baked.package).evaluate(lights);
  double here = 0.0, there = 0.0;
  for (std::uint32_t s = 0; s < samples.size(); ++s) {
    (samples.positions[s].x() > kSide + 0.5F * kGap ? there : here) +=
        std::abs(played.direct(s, 0)) + std::abs(played.indirect(s, 0));
  }
  EXPECT_GT(here, 0.0);
  EXPECT_EQ(there, 0.0);
}

TEST(Needless, LightFunctionsWithoutEffectAreLeftOut) {
  // Two walls that face each other, one of them black: what falls on that comes back nowhere.
  Scene scene;
  const auto grey = test::add_material(scene, Vec3f::Constant(0.5F));
  const auto black = test::add_material(scene, Vec3f::Zero());
  test::add_quad(scene, Vec3f::Zero(), {0, kSide, 0}, {0, 0, kSide}, grey);
  test::add_quad(scene, {kSide, 0, 0}, {0, 0, kSide}, {0, kSide, 0}, black);
  test::finish(scene);
  OptionValues options = small_bake();
  options.set("lb.light_rank", 12);
  const Baked baked(scene, options);
  const auto functions = baked.bake.result("light_functions");
  const auto& projection = std::get<ClusterProjection>(baked.package.operators.at("project"));
  for (std::size_t c = 0; c < baked.samples().clusters(); ++c) {
    if (baked.samples().positions[baked.samples().cluster_begin[c]].x() > 0.5F * kSide) {
      EXPECT_EQ(projection.blocks[c].rows, 1U);
    }
  }
  EXPECT_GT(functions->attribute<int>("needless"), 0);
  EXPECT_NE(
      baked.reason(std::to_string(functions->attribute<int>("needless")) + " light functions"), "");
  options.set("transport.tolerance", 1e-9);
  options.set("transport.bounces", 30);
  const Baked all(scene, options);
  EXPECT_GT(all.bake.result("light_functions")->attribute<int>("functions"),
            functions->attribute<int>("functions"));
  const auto lights = lights_within({0.2F, 0, 0}, {kSide - 0.2F, kSide, kSide});
  const double off =
      relative_difference(Evaluator(baked.package).evaluate(lights).indirect,
                          Evaluator(all.package).evaluate(lights).indirect, baked.samples());
  std::printf("light functions left out: %.5f of the indirect light\n", off);
  EXPECT_LT(off, 2e-2);
}

}  // namespace
}  // namespace prt
