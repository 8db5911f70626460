// Rooms with closed-form light: cells, hemispherical rays, gather and photons together.
#include <gtest/gtest.h>

#include <cmath>

#include "bases/depth_basis.h"
#include "methods/lb/lb.h"
#include "scene/load.h"
#include "statistical/test_scenes.h"
#include "support/partial_bake.h"
#include "transport/gather.h"
#include "transport/hemisphere.h"
#include "transport/photons.h"

namespace prt {
namespace {

constexpr int kDirections = 256;
// Sums of some thousand floats of like size.
constexpr double kFloat = 1e-5;
// Asked for of cells; 64 points per cell give 0.2 % of a room by stratification.
constexpr double kAreaTolerance = 0.01;
constexpr double kMostLost = 0.005;
// A ray that starts within rounding of an edge may pass it by: some 1 in 100,000.
constexpr double kLeak = 1e-4;

OptionValues small_bake() {
  OptionValues options = test::default_options(lb_method());
  options.set("samples.count", 1500);
  options.set("samples.cluster_size", 250);
  options.set("rays.directions", kDirections);
  return options;
}

struct Room {
  explicit Room(Scene s, const OptionValues& options = small_bake())
      : scene(std::move(s)), bake(scene, options) {
    test::run_kinds(bake, lb_method(), test::kSamplingAndRays);
    samples = test::samples_of(bake);
    senders = test::senders_of(bake, samples.clusters());
  }
  [[nodiscard]] double area() const {
    double sum = 0.0;
    for (const float a : samples.areas) sum += a;
    return sum;
  }
  [[nodiscard]] double mean(const MatrixF& field) const {
    double sum = 0.0;
    for (std::size_t s = 0; s < samples.size(); ++s) sum += samples.areas[s] * field(s, 0);
    return sum / area();
  }
  [[nodiscard]] MatrixF gather(const MatrixF& albedo, const MatrixF& field) const {
    return gather_fields(gather_entries(senders, directions.weights(), samples.size()), albedo,
                         {field})[0];
  }
  Scene scene;
  test::InProcessBake bake;
  SampleSet samples;
  std::vector<std::uint32_t> senders;
  HemisphereDirections directions{kDirections};
};

Scene shipped(const std::string& name) {
  return load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/" + name + ".glb");
}

const Room& closed_box() {  // 2 m wide, albedo 0.5
  static const Room room(shipped("closed_box"));
  return room;
}

MatrixF ones(const Room& room) {
  return MatrixF::Ones(static_cast<Eigen::Index>(room.samples.size()), 1);
}

TEST(Cells, OfAClosedBoxAreItsInsideAndNothingOutside) {
  const Room& room = closed_box();
  EXPECT_NEAR(room.area() / 24.0, 1.0, kAreaTolerance);
  for (std::size_t s = 0; s < room.samples.size(); ++s) {
    EXPECT_LT(room.samples.normals[s].dot(room.samples.positions[s]), 0.0F);
  }
}

TEST(Cells, LeaveOutWhatAStandingBoxHides) {
  Scene scene;
  const auto material = test::add_material(scene, Vec3f::Constant(0.5F));
  test::add_box(scene, Vec3f::Constant(-1.0F), Vec3f::Constant(1.0F), material);
  test::add_box(scene, {-0.4F, -1.0F, -0.4F}, {0.4F, -0.2F, 0.4F}, material);
  test::finish(scene);
  OptionValues options = small_bake();
  options.set("samples.start", {0.7F, 0.5F, 0.6F});
  const Room room(std::move(scene), options);
  // Five sides of the cube are there, the floor that it stands on is not.
  EXPECT_NEAR(room.area() / (24.0 + 5 * 0.64 - 0.64), 1.0, kAreaTolerance);
  for (const Vec3f& p : room.samples.positions) {
    const bool below = p.y() < -0.99F && std::abs(p.x()) < 0.39F && std::abs(p.z()) < 0.39F;
    EXPECT_FALSE(below) << p.transpose();
  }
}

TEST(Hemispheres, ShareOutAllLight) {
  const Room room(shipped("cornell"));
  const auto begin = room.samples.cluster_begin;
  const MatrixF gathered = room.gather(ones(room), ones(room));
  double escaped_anywhere = 0.0;
  for (std::size_t c = 0; c < room.samples.clusters(); ++c) {
    const auto rays = room.bake.result(numbered("rays", c));
    double sum = 0.0;
    double area = 0.0;
    for (auto s = begin[c]; s < begin[c + 1]; ++s) {
      sum += room.samples.areas[s] * gathered(s, 0);
      area += room.samples.areas[s];
    }
    const double escaped = rays->attribute<double>("escaped_share");
    const double lost = rays->attribute<double>("lost_share");
    EXPECT_NEAR(sum / area + escaped + lost, 1.0, kFloat) << c;
    EXPECT_LT(lost, kMostLost) << c;
    escaped_anywhere += escaped;
  }
  EXPECT_GT(escaped_anywhere, 0.1);  // the box is open in front
}

TEST(Hemispheres, MeasureTheDistanceToTheWalls) {
  const Room& room = closed_box();
  const float bound = room.scene.diagonal();
  const auto depths = room.bake.result("rays/0000")->values<std::uint16_t>("distance");
  // Half a step of 65534 in √(t / bound), twice for float's rounding; and the lift of the origin,
  // 2^-16 of the box's size, along a ray.
  constexpr float kStep = 1.0F / 65534.0F;
  constexpr float kLift = 1e-4F;
  int in_edges = 0;
  for (std::uint32_t s = 0; s < room.samples.cluster_begin[1]; ++s) {
    // In an edge, within rounding, a sample sees two walls at no distance.
    const auto walls = (room.samples.positions[s].array().abs() > 1.0F - kLift).count();
    if (walls > 1) {
      ++in_edges;
      continue;
    }
    const Mat3f frame = room.samples.frame(s);
    for (int d = 0; d < kDirections; ++d) {
      const Vec3f way = frame * room.directions.direction(d);
      float t = kInfinity;
      for (int axis = 0; axis < 3; ++axis) {
        if (way[axis] == 0.0F) continue;
        const float wall = std::copysign(1.0F, way[axis]);
        t = std::min(t, std::max(0.0F, (wall - room.samples.positions[s][axis]) / way[axis]));
      }
      const float depth = unpack_depth(depths[s * kDirections + d]);
      ASSERT_NEAR(depth * depth * bound, t, 2.0F * kStep * depth * bound + kLift) << s << ' ' << d;
    }
  }
  EXPECT_LT(in_edges, 3);
}

TEST(Furnace, GatheredBouncesAddUpToTheClosedForm) {
  const Room& room = closed_box();
  for (const float rho : {0.5F, 0.9F}) {
    const MatrixF albedo = rho * ones(room);
    MatrixF term = ones(room);
    MatrixF sum = 0.0F * term;
    for (int i = 0; i < 300; ++i) {  // 0.9^300 is 2e-14
      term = room.gather(albedo, term);
      sum += term;
    }
    const double expected = rho / (1.0 - rho);
    // Every ray meets a wall that a sample stands for, so the rows sum to 1 but for rounding.
    EXPECT_NEAR(sum.maxCoeff() / expected, 1.0, 10 * kFloat) << rho;
    EXPECT_NEAR(sum.minCoeff() / expected, 1.0, 10 * kFloat) << rho;
  }
}

TEST(Furnace, TheScenesAlbedoIsWhatItsFileSays) {
  const MatrixF albedo = closed_box().bake.result(kAlbedoTask)->matrix("albedo");
  EXPECT_NEAR(albedo.maxCoeff(), 0.5F, 1e-6F);
  EXPECT_NEAR(albedo.minCoeff(), 0.5F, 1e-6F);
}

/// Indirect irradiance caused by direct irradiance 1 everywhere, from `photons` per cluster.
MatrixF shoot_constant(const Room& room, std::uint64_t photons, int bounces) {
  const SenderSearch search(room.scene, room.samples);
  const CellPoints points = test::cell_points_of(room.bake);
  MatrixF sum = 0.0F * ones(room);
  double leaked = 0.0;
  double flights = 0.0;
  for (std::uint32_t c = 0; c < room.samples.clusters(); ++c) {
    const PhotonTransfer shot = shoot_photons(
        room.scene, room.bake.caster(), room.samples, search, points, c,
        MatrixF::Ones(1, room.samples.cluster_size(c)), 1, {photons, bounces, 100 + c});
    leaked += static_cast<double>(shot.escaped + shot.lost);
    flights += static_cast<double>(shot.flights);
    sum += shot.irradiance;
  }
  EXPECT_LE(leaked, kLeak * flights);
  return sum;
}

TEST(Furnace, PhotonsAddUpToTheClosedForm) {
  const Room& room = closed_box();
  constexpr std::uint64_t kPhotons = 20000;
  const double all = static_cast<double>(kPhotons * room.samples.clusters());
  // A photon deposits as often as it survives. All bounces at 0.5: mean 1, variance 2. One bounce:
  // mean and variance of a coin. Clusters differ little in area, so shots weigh nearly alike.
  constexpr double kSigmas = 4.0;
  EXPECT_NEAR(room.mean(shoot_constant(room, kPhotons, -1)), 1.0, kSigmas * std::sqrt(2.0 / all));
  EXPECT_NEAR(room.mean(shoot_constant(room, kPhotons, 1)), 0.5, kSigmas * std::sqrt(0.25 / all));
  EXPECT_NEAR(room.mean(shoot_constant(room, kPhotons, 2)), 0.75,
              kSigmas * std::sqrt(0.6875 / all));  // E n² − E² n = (¼·1 + ¼·4) − 0.5625
}

TEST(Furnace, PhotonsAreEvenlySpread) {
  const Room& room = closed_box();
  const MatrixF e = shoot_constant(room, 20000, -1);
  // Each cluster alone: some 20,000 deposits of variance near 1 each, and cells of 64 points.
  const auto& begin = room.samples.cluster_begin;
  for (std::size_t c = 0; c < room.samples.clusters(); ++c) {
    double sum = 0.0;
    double area = 0.0;
    for (auto s = begin[c]; s < begin[c + 1]; ++s) {
      sum += room.samples.areas[s] * e(s, 0);
      area += room.samples.areas[s];
    }
    EXPECT_NEAR(sum / area, 1.0, 0.05) << c;
  }
}

}  // namespace
}  // namespace prt
