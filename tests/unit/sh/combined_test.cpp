// Several methods in one bake.
#include "methods/combined.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "methods/lb/lb.h"
#include "player/evaluator.h"
#include "sky_scenes.h"

namespace prt {
namespace {

using test::InProcessBake;

OptionValues options_of(const Method& method) {
  OptionValues options = test::sky_options(method, 400, {1, 1, 1});
  options.set("rays.directions", 256);
  if (method.name() != "sh") {
    options.set("lb.example_lights", 60);
    options.set("lb.light_rank", 8);
  }
  return options;
}

Package bake(const Scene& scene, const Method& method,
             std::multiset<std::string>* kinds = nullptr) {
  InProcessBake run(scene, options_of(method));
  const Plan plan = run.run(method);
  EXPECT_TRUE(plan.complete);
  for (const TaskSpec& task : plan.tasks) {
    if (kinds != nullptr) kinds->insert(task.kind);
  }
  Package package =
      method.assemble([&](const std::string& id) { return run.result(id); }, run.options());
  package.scene = scene;
  return package;
}

TEST(Combined, OfOneMethodIsThatMethod) {
  EXPECT_EQ(combined({&lb_method()}).get(), &lb_method());
  EXPECT_EQ(combined({&lb_method(), &sh_method()})->name(), "lb+sh");
}

TEST(Combined, SharesWhatBothNeedAndAddsWhatTheyPlay) {
  const Scene scene = test::open_box(Vec3f(0.6F, 0.5F, 0.4F));
  const auto both = combined({&lb_method(), &sh_method()});
  std::multiset<std::string> of_lb, of_both;
  const Package lb = bake(scene, lb_method(), &of_lb);
  const Package sh = bake(scene, sh_method());
  const Package together = bake(scene, *both, &of_both);
  validate(together, "both methods");
  for (const char* shared : {"candidates", "samples", "rays", "albedo"}) {
    EXPECT_EQ(of_both.count(shared), of_lb.count(shared)) << shared;
  }
  Light light;
  light.position = Vec3f(1.0F, 1.4F, 0.8F);
  MatrixF sky = MatrixF::Zero(3, 25);
  sky.col(0).setConstant(2.0F);
  sky.col(1).setConstant(0.5F);
  const Evaluator player(together);
  const auto everything = player.evaluate({&light, 1}, sky);
  const auto by_lights = Evaluator(lb).evaluate({&light, 1});
  const auto by_sky = Evaluator(sh).evaluate({}, sky);
  EXPECT_EQ(everything.direct, by_lights.direct);
  EXPECT_EQ(everything.sky, by_sky.sky);
  EXPECT_TRUE(everything.indirect.isApprox(by_lights.indirect + by_sky.indirect, 1e-5F));
  EXPECT_GT(by_sky.indirect.norm(), 0.0F);
  EXPECT_EQ(player.evaluate({&light, 1}).indirect, by_lights.indirect);
}

TEST(Combined, PlaysLightsAloneWhereNoSkyGetsIn) {
  Scene scene;
  test::add_box(scene, Vec3f::Zero(), Vec3f::Constant(2.0F),
                test::add_material(scene, Vec3f::Constant(0.5F)));
  test::finish(scene);
  const Package package = bake(scene, *combined({&lb_method(), &sh_method()}));
  validate(package, "a closed scene");
  EXPECT_TRUE(has_direct_light(package));
  EXPECT_EQ(environment_order(package), 0);
}

TEST(Combined, RefusesTwoPartsOfOneName) {
  const Scene scene = test::open_box(Vec3f::Constant(0.5F));
  Package part = bake(scene, sh_method());
  EXPECT_THROW(add_part(part, part), std::logic_error);
}

TEST(Combined, ToldOfAKindThatNobodyKnowsSaysNothing) {
  const auto both = combined({&lb_method(), &sh_method()});
  EXPECT_EQ(both->equation("compare"), "");
  EXPECT_EQ(both->equation("rays"), lb_method().equation("rays"));
  EXPECT_EQ(sh_method().equation("rays"), lb_method().equation("rays"));
  EXPECT_EQ(sh_method().equation("samples"), lb_method().equation("samples"));
}

}  // namespace
}  // namespace prt
