// Packages judged under environments: an open box whose transfer is known to be right, and spoiled.
#include "evaluate/compare_sky.h"

#include <gtest/gtest.h>

#include "evaluate/sky_evaluation.h"
#include "player/environment_light.h"
#include "scene/embree/embree_ray_caster.h"
#include "unit/sh/sky_scenes.h"

namespace prt {
namespace {

constexpr int kOrder = 4;

class CompareSky : public testing::Test {
 protected:
  static Package baked(const Scene& scene) {
    OptionValues options = test::sky_options(sh_method(), 1500, {1, 1, 1});
    options.set("sh.order", kOrder);
    options.set("transport.tolerance", 1e-3);
    options.set("compression.tolerance", 1e-3);
    test::InProcessBake bake(scene, options);
    bake.run(sh_method());
    Package package =
        sh_method().assemble([&](const std::string& id) { return bake.result(id); }, options);
    package.scene = scene;
    return package;
  }
  nlohmann::json judge(const Package& package, float play_scale = 1.0F) const {
    const SenderSearch search(scene_, package.samples);
    ReferenceSettings settings;
    settings.points = 300;
    settings.paths = 512;
    const TestPoints reference = trace_sky_reference({scene_, *caster_, package.samples, search},
                                                     settings, 0, sky_, 0, [] {});
    const MatrixF coefficients = play_scale * EnvironmentLight(sky_, kOrder).coefficients();
    const SkyErrors errors = compare_sky(Evaluator(package), coefficients, reference);
    EXPECT_EQ(errors.not_finite(), 0U);
    return sky_error_report({&errors, 1});
  }
  Scene scene_ = test::open_box(Vec3f(0.6F, 0.5F, 0.3F));
  std::unique_ptr<RayCaster> caster_ = make_embree_ray_caster(scene_);
  Environment sky_ = test::two_bands(Vec3f(1.0F, 0.8F, 0.6F));
  Package package_ = baked(scene_);
};

TEST_F(CompareSky, FindsABandLimitedSkyRightAtSamplesAndOnTheSurface) {
  // What 1008 directions make of the lid's edge, and what splats make of corners.
  constexpr double kQuadrature = 0.03, kSplats = 0.06;
  const nlohmann::json report = judge(package_);
  for (const char* part : {"direct", "indirect", "total"}) {
    const double noise = report[part]["standard_error"];
    EXPECT_LT(report[part]["rel_rmse"].get<double>(), kQuadrature + 3.0 * noise) << part;
    EXPECT_LT(report[part]["surface"]["rel_rmse"].get<double>(), kSplats + 3.0 * noise) << part;
    EXPECT_LT(noise, 0.02) << part;
  }
  EXPECT_EQ(report["environments"], 1U);
  EXPECT_EQ(report["unreached_share"].get<double>(), 0.0);
}

TEST_F(CompareSky, SeesAnErrorOfTenPerCentAndALayerThatIsMissing) {
  const nlohmann::json brighter = judge(package_, 1.1F);
  for (const char* part : {"direct", "indirect", "total"}) {
    EXPECT_NEAR(brighter[part]["rel_rmse"].get<double>(), 0.1, 0.03) << part;
  }
  Package without = package_;
  without.program = {EnvironmentLightStep{"sky", "sky_light", "sky"}, ReconstructStep{"sky"}};
  const nlohmann::json direct_only = judge(without);
  EXPECT_NEAR(direct_only["indirect"]["rel_rmse"].get<double>(), 1.0, 1e-5);
  EXPECT_GT(direct_only["total"]["rel_rmse"].get<double>(), 0.05);
}

TEST(TestEnvironments, AreSmoothColouredAndTheirOwn) {
  const Environment first = draw_test_environment(1, 0), second = draw_test_environment(1, 1);
  EXPECT_EQ(first.cells(), draw_test_environment(1, 0).cells());
  EXPECT_NE(first.cells(), second.cells());
  EXPECT_NE(first.cells(), draw_test_environment(2, 0).cells());
  const VectorD energy =
      band_energy(8, EnvironmentLight(first, 8).coefficients().transpose().cast<double>());
  EXPECT_LT(energy.tail(3).sum(), 0.01 * energy.sum());
  EXPECT_GT(energy.segment(1, 3).sum(), 0.01 * energy.sum());
  for (const Vec3f& radiance : first.cells()) ASSERT_GT(radiance.minCoeff(), 0.0F);
}

}  // namespace
}  // namespace prt
