// An empty box judged end to end: its direct light is known exactly, its indirect light left out.
#include "evaluate/compare.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "evaluate/error_picture.h"
#include "evaluate/light_errors_io.h"
#include "scene/embree/embree_ray_caster.h"
#include "transport/free_space.h"
#include "unit/evaluate/box_room.h"

namespace prt {
namespace {

/// Float rounding of direct light, relative.
constexpr double kRounding = 1e-5;

class Compare : public testing::Test {
 protected:
  LightReference trace(std::size_t number, unsigned threads) const {
    ReferenceSettings settings;
    settings.points = 200;
    settings.paths = 32;
    settings.clearance = kTestClearance * samples_diagonal(package_.samples);
    return trace_reference({scene_, *caster_, package_.samples, search_}, settings, number, threads,
                           [] {});
  }
  static Package unshadowed() {
    Package package;
    package.samples = test::box_samples();
    package.spaces = {{"direct", Space::Kind::kSampleIrradiance,
                       static_cast<std::uint32_t>(package.samples.size())}};
    package.program = {DirectLightStep{"direct", DirectLightStep::Shadow::kNone},
                       ReconstructStep{"direct"}};
    return package;
  }

  Scene scene_ = test::box_room(0.5F);
  std::unique_ptr<RayCaster> caster_ = make_embree_ray_caster(scene_);
  Package package_ = unshadowed();
  SenderSearch search_{scene_, package_.samples};
  Evaluator player_{package_};
};

TEST_F(Compare, DirectLightOfAnEmptyBoxIsExactAndIndirectIsMissing) {
  const std::vector<LightErrors> lights = {compare(player_, trace(0, 1)),
                                           compare(player_, trace(1, 1))};
  const nlohmann::json report = error_report(lights);
  EXPECT_LT(report["direct"]["rel_rmse"].get<double>(), kRounding);
  EXPECT_LT(report["direct"]["surface"]["rel_rmse"].get<double>(), kRounding);
  EXPECT_NEAR(report["indirect"]["rel_rmse"].get<double>(), 1.0, kRounding);
  EXPECT_NEAR(report["indirect"]["surface"]["rel_rmse"].get<double>(), 1.0, kRounding);
  EXPECT_EQ(report["visibility_error"].get<double>(), 0.0);
  EXPECT_EQ(report["unreached_share"].get<double>(), 0.0);
  EXPECT_EQ(report["lights"].get<std::size_t>(), 2U);
}

TEST_F(Compare, ErrorOfTransferIsJudgedUnderExactDirectLight) {
  // Played shadows are no part of it: with a program that passes direct light on, indirect light is
  // what the reference says of direct light.
  Package passing = unshadowed();
  NearTransfer all;
  all.channels = 1;
  all.begin = {0};
  const auto n = static_cast<std::uint32_t>(passing.samples.size());
  for (std::uint32_t s = 0; s < n; ++s) {
    all.senders.push_back(s);
    all.shares.push_back(pack_share(1.0F));
    all.begin.push_back(s + 1);
  }
  all.albedo.assign(n, pack_share(1.0F));
  passing.operators.emplace("near", all);
  passing.spaces.push_back({"near", Space::Kind::kSampleIrradiance, n});
  passing.spaces.push_back({"all", Space::Kind::kSampleIrradiance, n});
  passing.program = {DirectLightStep{"direct", DirectLightStep::Shadow::kNone},
                     ApplyStep{"near", "direct", "near"}, AddStep{"direct", "near", "all"},
                     ReconstructStep{"all"}};
  LightReference reference = trace(0, 1);
  for (std::size_t i = 0; i < reference.sample_index.size(); ++i) {
    const float exact = 0.5F * reference.direct[reference.sample_index[i]];
    reference.at_samples.reference[i].indirect = {Vec3f::Constant(exact), Vec3f::Constant(exact)};
  }
  for (float& direct : reference.direct) direct *= 0.5F;
  const auto report = error_report(std::array{compare(Evaluator(passing), reference)});
  EXPECT_NEAR(report["indirect"]["rel_rmse"].get<double>(), 1.0, 1e-3);
  EXPECT_NEAR(report["indirect"]["exact_direct"]["rel_rmse"].get<double>(), 0.0, 1e-3);
}

TEST_F(Compare, SeesAnErrorOfTenPerCent) {
  LightReference reference = trace(0, 1);
  for (float& direct : reference.direct) direct /= 1.1F;
  const LightErrors errors = compare(player_, reference);
  EXPECT_NEAR(irradiance_error({&errors.direct, 1}).rel_rmse, 0.1, 1e-4);
}

TEST_F(Compare, NamesTheWorstLightAndTheWorstCluster) {
  std::vector<LightReference> references = {trace(0, 1), trace(1, 1), trace(2, 1)};
  const SampleSet& samples = package_.samples;
  for (float& direct : references[0].direct) direct *= 1.05F;
  for (std::uint32_t s = samples.cluster_begin[4]; s < samples.cluster_begin[5]; ++s) {
    references[2].direct[s] *= 3.0F;
  }
  std::vector<LightErrors> lights;
  lights.reserve(references.size());
  for (const LightReference& reference : references) lights.push_back(compare(player_, reference));
  const auto report = error_report(lights)["direct"];
  EXPECT_EQ(report["worst_light"]["light"], 2U);
  EXPECT_NEAR(report["worst_light"]["position"][1].get<double>(), lights[2].position.y(), 1e-6);
  EXPECT_EQ(report["worst_cluster"]["cluster"], 4U);
  EXPECT_GT(report["worst_cluster"]["error_share"].get<double>(), 0.9);
  // Nothing wrong, nobody worst.
  const auto exact = error_report({&lights[1], 1})["direct"];
  EXPECT_TRUE(exact["worst_light"].is_null() ||
              exact["worst_light"]["rel_rmse"].get<double>() < kRounding);
  EXPECT_TRUE(error_report({})["direct"]["worst_cluster"].is_null());
}

TEST_F(Compare, WhatLightsToldIsStoredAsItIs) {
  std::vector<LightErrors> lights = {compare(player_, trace(0, 1)), compare(player_, trace(1, 1))};
  lights[1].unreached = 0.25;
  lights[0].visibility.wrong = 0.125;
  lights[1].direct_by_cluster[0].squared_error = 9.0;
  Artifact stored;
  put_light_errors(stored, lights);
  EXPECT_EQ(error_report(get_light_errors(stored)), error_report(lights));
  EXPECT_EQ(get_light_errors(stored)[1].direct_by_cluster.size(), package_.samples.clusters());

  stored.put<double>("unreached", std::vector<double>{0.0}, {1}, "1", "of one light alone");
  EXPECT_THROW((void)get_light_errors(stored), UnsoundData);
}

TEST_F(Compare, PlacesTheWorstLightsInTheWorld) {
  const LightErrors errors = compare(player_, trace(0, 1));
  nlohmann::json report = error_report({&errors, 1});
  report["direct"]["worst_light"] = {{"light", 0}, {"position", {0.1F, -2.0F, 3.0F}}};
  report["indirect"]["worst_light"] = nullptr;
  const nlohmann::json before = report;
  place_in_world(report, Vec3d::Zero());
  EXPECT_EQ(report, before);
  place_in_world(report, Vec3d(1e8, 2, 0));
  EXPECT_EQ(report["direct"]["worst_light"]["position"],
            (nlohmann::json{1e8 + double{0.1F}, 0.0, 3.0}));
  EXPECT_TRUE(report["indirect"]["worst_light"].is_null());
}

TEST_F(Compare, SeesALightThatIsHidden) {
  LightReference reference = trace(0, 1);
  std::ranges::fill(reference.direct, 0.0F);
  const LightErrors errors = compare(player_, reference);
  EXPECT_EQ(visibility_error({&errors.visibility, 1}).wrong_share, 1.0);
}

TEST_F(Compare, DirectLightAtEverySampleIsThePathTracers) {
  Scene scene = test::box_room(0.5F);
  test::add_box(scene, Vec3f::Constant(0.7F), Vec3f::Constant(1.3F), 0);
  test::finish(scene);
  const auto caster = make_embree_ray_caster(scene);
  const SenderSearch search(scene, package_.samples);
  ReferenceSettings settings;
  settings.points = package_.samples.size();
  settings.paths = 2;
  const LightReference reference =
      trace_reference({scene, *caster, package_.samples, search}, settings, 2, 1, [] {});
  ASSERT_EQ(reference.direct.size(), package_.samples.size());
  std::size_t dark = 0;
  for (std::size_t i = 0; i < reference.sample_index.size(); ++i) {
    const float traced = reference.at_samples.reference[i].direct[0].x();
    EXPECT_NEAR(reference.direct[reference.sample_index[i]], traced, 1e-5F * traced);
    dark += traced == 0.0F ? 1 : 0;
  }
  EXPECT_GT(dark, 20U);
  EXPECT_LT(dark, reference.direct.size() / 2);
}

TEST_F(Compare, ThreadsAndRepetitionChangeNothing) {
  const LightReference one = trace(3, 1), two = trace(3, 2), other = trace(4, 1);
  EXPECT_EQ(one.light.position, two.light.position);
  EXPECT_NE(one.light.position, other.light.position);
  ASSERT_EQ(one.on_surface.points.size(), two.on_surface.points.size());
  for (std::size_t i = 0; i < one.on_surface.points.size(); ++i) {
    EXPECT_EQ(one.on_surface.points[i].position, two.on_surface.points[i].position);
    EXPECT_EQ(one.on_surface.reference[i].indirect, two.on_surface.reference[i].indirect);
    EXPECT_EQ(one.at_samples.reference[i].indirect, two.at_samples.reference[i].indirect);
  }
}

TEST_F(Compare, TestPointsAreOnTheInsideAndEvenlySpread) {
  const LightReference reference = trace(0, 1);
  const Vec3f centre = Vec3f::Constant(0.5F * test::kBoxSide);
  int walls[3][2] = {};
  for (const ReceiverPoint& p : reference.on_surface.points) {
    EXPECT_GT(p.normal.dot(centre - p.position), 0.0F);
    int axis = 0;
    p.normal.cwiseAbs().maxCoeff(&axis);
    ++walls[axis][p.normal[axis] > 0.0F];
  }
  // 200 points stratified over six equal walls.
  for (const auto& pair : walls) {
    for (const int count : pair) EXPECT_NEAR(count, 200.0 / 6.0, 3.5);
  }
  float weight = 0.0F;
  for (const float w : reference.at_samples.weights) weight += w;
  EXPECT_NEAR(weight, 1.0F, 1e-5F);
}

TEST_F(Compare, AsManyPointsAsSamplesMeansAllOfThem) {
  LightReference reference;
  ReferenceSettings settings;
  settings.points = package_.samples.size();
  choose_sample_points(package_.samples, settings, 0, reference);
  EXPECT_EQ(reference.sample_index.size(), package_.samples.size());
  EXPECT_EQ(reference.sample_index.back(), package_.samples.size() - 1);
}

TEST_F(Compare, ErrorPictureIsWhiteWhereRightAndBlueWhereLightIsMissing) {
  package_.scene = scene_;
  SceneCamera camera;
  camera.eye = Vec3f(1.0F, 1.0F, 1.9F);
  camera.target = Vec3f(1.0F, 1.0F, 0.0F);
  Light light;
  light.position = Vec3f(0.6F, 1.3F, 1.0F);
  ErrorPictureSettings settings;
  settings.width = 40;
  settings.height = 30;
  settings.paths = 64;
  const Picture picture =
      draw_error(player_, {scene_, *caster_, package_.samples, search_}, light, camera, settings);
  ASSERT_EQ(picture.width, 80);
  ASSERT_EQ(picture.covered, 1200U);  // the room is closed
  EXPECT_EQ(picture.not_finite, 0U);
  std::array<int, 2> pale{}, blue{};
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 80; ++x) {
      const std::uint8_t* rgb = &picture.rgb[3 * static_cast<std::size_t>(y * 80 + x)];
      const std::size_t panel = x < 40 ? 0 : 1;
      pale[panel] += rgb[0] > 240 && rgb[2] > 240 ? 1 : 0;
      blue[panel] += rgb[0] < 40 && rgb[2] > 180 ? 1 : 0;
    }
  }
  EXPECT_EQ(pale[0], 1200);  // direct light is exact
  EXPECT_EQ(blue[0], 0);
  EXPECT_EQ(blue[1], 1200);  // of the indirect light nothing is there
  EXPECT_EQ(pale[1], 0);
}

}  // namespace
}  // namespace prt
