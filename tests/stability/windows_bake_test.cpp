// A scene solved for in regions: what the whole of it gives, but for what windows leave out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "methods/lb/scene_part.h"
#include "stability/small_bake.h"
#include "statistical/test_scenes.h"

namespace prt {
namespace {

using test::SmallBake;

/// Rooms in a row, 2 m each, with walls between them that leave `gap` metres open.
Scene rooms(int count, float gap) {
  Scene scene;
  const auto length = static_cast<float>(2 * count);
  test::add_box(scene, {0, 0, 0}, {length, 2, 2}, test::add_material(scene, {0.7F, 0.5F, 0.4F}));
  const auto wall = test::add_material(scene, {0.4F, 0.6F, 0.7F});
  for (int i = 1; i < count; ++i) {
    const auto x = static_cast<float>(2 * i);
    for (const float side : {-0.05F, 0.05F}) {
      test::add_quad(scene, {x + side, 0, 0}, {0, 2, 0}, {0, 0, 2 - gap}, wall);
    }
    if (gap > 0.0F) {
      test::add_quad(scene, {x - 0.05F, 0, 2 - gap}, {0.1F, 0, 0}, {0, 2, 0}, wall);
    }
  }
  test::finish(scene);
  return scene;
}

/// Every direction of direct light has a function, and compression costs nothing: what is left of
/// a difference is what regions and windows do.
OptionValues exact_options() {
  OptionValues options = test::small_options();
  options.set("samples.count", 450);
  options.set("samples.cluster_size", 25);
  options.set("lb.light_rank", 25);
  options.set("lb.example_lights", 600);
  options.set("compression.bits", 16);
  options.set("compression.tolerance", 1e-5);
  options.set("transport.tolerance", 1e-4);
  options.set("samples.start", {1.0, 1.0, 1.0});
  return options;
}

OptionValues in_regions(OptionValues options, int clusters, double tolerance) {
  options.set("lb.region_clusters", clusters);
  options.set("lb.window_tolerance", tolerance);
  return options;
}

/// ‖a − b‖ / ‖b‖ over the samples that `inside` holds for, weighted by area.
template <typename Inside>
double difference(const SmallBake& bake, const MatrixF& a, const MatrixF& b, Inside&& inside) {
  double off = 0.0;
  double all = 0.0;
  const SampleSet& samples = bake.samples();
  for (std::size_t s = 0; s < samples.size(); ++s) {
    if (!inside(samples.positions[s])) continue;
    const auto row = static_cast<Eigen::Index>(s);
    off += samples.areas[s] * (a.row(row) - b.row(row)).cast<double>().squaredNorm();
    all += samples.areas[s] * b.row(row).cast<double>().squaredNorm();
  }
  return std::sqrt(off / all);
}

std::vector<Region> regions_of(const SmallBake& bake) {
  return lb::get_regions(*bake.bake().result(lb::kWindowsTask));
}

class InRegions : public testing::Test {
 protected:
  const Vec3f light_{1.1F, 1.2F, 0.7F};
  /// What the whole scene gives.
  [[nodiscard]] SampleIrradiance expected() const {
    static const SmallBake whole(rooms(3, 0.5F), exact_options());
    return whole.light(light_);
  }
  static bool anywhere(const Vec3f&) { return true; }
};

TEST_F(InRegions, WithAllInEveryWindowTheSolutionIsThatOfTheWhole) {
  const SmallBake bake(rooms(3, 0.5F), in_regions(exact_options(), 6, 0.0));
  const auto regions = regions_of(bake);
  ASSERT_GE(regions.size(), 3U);
  for (const Region& region : regions) ASSERT_EQ(region.window.size(), bake.samples().clusters());
  const SampleIrradiance lit = bake.light(light_);
  EXPECT_EQ(lit.direct, expected().direct);
  const double off = difference(bake, lit.indirect, expected().indirect, anywhere);
  EXPECT_LT(off, 0.002);
}

TEST_F(InRegions, SmallerWindowsLoseNoMoreThanTheTolerance) {
  for (const double tolerance : {0.3, 0.03}) {
    const SmallBake bake(rooms(3, 0.5F), in_regions(exact_options(), 6, tolerance));
    std::size_t windows = 0;
    const auto regions = regions_of(bake);
    for (const Region& region : regions) windows += region.window.size();
    EXPECT_LT(windows, regions.size() * bake.samples().clusters()) << tolerance;
    const SampleIrradiance lit = bake.light(light_);
    const double off = difference(bake, lit.indirect, expected().indirect, anywhere);
    EXPECT_LT(off, tolerance) << "of light from one room";
    EXPECT_GT(off, 0.02 * tolerance) << "as good as nothing was left out";
    const auto& left_out = bake.plan().left_out;
    EXPECT_TRUE(std::ranges::any_of(
        left_out, [](const LeftOut& l) { return l.what == "transfer between distant clusters"; }));
  }
}

TEST_F(InRegions, OneBounceAndTwoAreThoseOfTheWhole) {
  for (const int bounces : {1, 2}) {
    OptionValues options = exact_options();
    options.set("transport.bounces", bounces);
    const SmallBake whole(rooms(3, 0.5F), options);
    const SmallBake bake(rooms(3, 0.5F), in_regions(options, 6, 0.0));
    EXPECT_LT(difference(bake, bake.light(light_).indirect, whole.light(light_).indirect, anywhere),
              0.01)
        << bounces;
  }
}

TEST(RegionsOfAWhiteRoom, AreRefusedOrBounded) {
  const auto white = [] {
    Scene scene;
    test::add_box(scene, {0, 0, 0}, {2, 2, 2}, test::add_material(scene, Vec3f::Ones()));
    test::finish(scene);
    return scene;
  };
  OptionValues options = in_regions(exact_options(), 6, 0.01);
  EXPECT_THROW(SmallBake(white(), options), UserError);
  options.set("transport.bounces", 3);
  const SmallBake bounded(white(), options);
  EXPECT_TRUE(bounded.light(Vec3f(1.1F, 1.2F, 0.7F)).indirect.allFinite());
}

TEST(SealedRooms, ExchangeNothingInRegions) {
  OptionValues options = in_regions(exact_options(), 6, 0.0);
  options.set("samples.start", {{1.0, 1.0, 1.0}, {6.0, 1.0, 1.0}});
  // So far apart that no cluster has samples of both.
  Scene scene = rooms(1, 0.0F);
  test::add_box(scene, {5, 0, 0}, {7, 2, 2}, 0);
  test::finish(scene);
  const SmallBake bake(std::move(scene), options);
  const auto room = [&](std::uint32_t cluster) {
    return bake.samples().positions[bake.samples().cluster_begin[cluster]].x() > 3.0F;
  };
  std::size_t of_one_room = 0;
  std::size_t in_second = 0;
  for (const Region& region : regions_of(bake)) {
    const auto second = std::ranges::count_if(region.clusters, room);
    in_second += static_cast<std::size_t>(second);
    of_one_room += second == 0 || second == std::ssize(region.clusters) ? 1 : 0;
    for (const std::uint32_t c : region.window) {
      EXPECT_TRUE(std::ranges::any_of(region.clusters,
                                      [&](std::uint32_t own) { return room(own) == room(c); }));
    }
  }
  EXPECT_GT(in_second, 0U);
  EXPECT_LT(in_second, bake.samples().clusters());
  EXPECT_GT(of_one_room, 0U) << "regions of both rooms say nothing";
}

}  // namespace
}  // namespace prt
