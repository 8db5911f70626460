// Points are the same whether one task thins all candidates or many thin those of their tiles.
#include <gtest/gtest.h>

#include "base/error.h"
#include "scene/load.h"
#include "support/in_process_bake.h"
#include "support/partial_bake.h"
#include "support/tiled_sampling.h"

namespace prt {
namespace {

const std::set<std::string> kUpToPoints = {"start",   "candidates", "tiles", "highest",
                                           "spacing", "thin",       "points"};

struct Sampled {
  std::shared_ptr<const Artifact> points;
  std::shared_ptr<const Artifact> spacing;  ///< null where it is not looked for
  std::size_t thin_tasks = 0;
  std::size_t candidates = 0;
  std::size_t left = 0;  ///< by the tiles
};

Sampled bake_points(const Scene& scene, const OptionValues& options, const ThinningSplit& split) {
  const test::TiledSampling method(split);
  test::InProcessBake bake(scene, options);
  test::run_kinds(bake, method, kUpToPoints);
  Sampled sampled{bake.result("points"), bake.result("spacing")};
  for (const TaskSpec& task : method.plan(bake).tasks) {
    if (task.kind == "candidates") {
      sampled.candidates += bake.result(task.id)->at("triangle").dims[0];
    } else if (task.kind == "thin") {
      ++sampled.thin_tasks;
      sampled.left += bake.result(task.id)->at("number").dims[0];
    }
  }
  return sampled;
}

void expect_same(const Artifact& a, const Artifact& b) {
  EXPECT_EQ(a.attributes, b.attributes);
  ASSERT_EQ(a.datasets.size(), b.datasets.size());
  for (const auto& [name, dataset] : a.datasets) {
    EXPECT_EQ(dataset.dims, b.at(name).dims) << name;
    EXPECT_TRUE(dataset.bytes == b.at(name).bytes) << name;
  }
}

Scene scene_named(const std::string& name) {
  return load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/" + name + ".glb");
}

OptionValues options_for(const std::string& key, double value) {
  OptionValues options;
  for (const auto& spec : shared_options()) options.set(spec.key, spec.fallback);
  if (key == "samples.count") {
    options.set(key, static_cast<std::size_t>(value));
  } else {
    options.set(key, value);
  }
  options.set("samples.cluster_size", 500);
  return options;
}

/// Of three candidate tasks.
constexpr double kSamples = 9000;

class TilesBake : public testing::TestWithParam<const char*> {};

TEST_P(TilesBake, HasThePointsOfOneTask) {
  const Scene scene = scene_named(GetParam());
  const OptionValues options = options_for("samples.count", kSamples);
  const Sampled whole = bake_points(scene, options, {});
  ASSERT_EQ(whole.thin_tasks, 0U);
  for (const ThinningSplit& split : {ThinningSplit{80000, 1, 2}, {30000, 2, 3}, {26000, 9, 99}}) {
    const Sampled tiled = bake_points(scene, options, split);
    EXPECT_GT(tiled.thin_tasks, 1U);
    EXPECT_LT(tiled.left, tiled.candidates);
    expect_same(*whole.points, *tiled.points);
    const double radius = tiled.points->attribute<double>("spacing");
    // So that the candidates were not all read.
    EXPECT_GE(radius, tiled.spacing->attribute<double>("low"));
    EXPECT_LE(radius, tiled.spacing->attribute<double>("high"));
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, TilesBake, testing::Values("closed_box", "gallery"));

TEST(TilesOfAScene, ReadsAllCandidatesWhereTheRadiusIsNotInTheRange) {
  const Scene scene = scene_named("closed_box");
  const OptionValues options = options_for("samples.count", kSamples);
  const test::TiledSampling method({60000, 1, 2});
  test::InProcessBake bake(scene, options);
  test::run_kinds(bake, method, kUpToPoints);
  const auto points = bake.result("points");
  for (const TaskSpec& task : method.plan(bake).tasks) {
    if (task.kind == "spacing") {
      bake.run_task(task, [&](const TaskReader&) {
        Artifact misled = *bake.result("spacing");
        misled.attributes["low"] = misled.attributes["first"];
        misled.attributes["high"] = misled.attributes["first"];
        return misled;
      });
    } else if (task.kind == "thin" || task.kind == "points") {
      bake.run_task(method, task);
    }
  }
  const auto spacing = bake.result("spacing");
  EXPECT_LT(points->attribute<double>("spacing"), spacing->attribute<double>("low"));
  EXPECT_NE(bake.result("points"), points);
  expect_same(*points, *bake.result("points"));
}

TEST(TilesOfAScene, AtAGivenSpacingLeavesLittleMoreThanThePoints) {
  const Scene scene = scene_named("cornell");
  const OptionValues by_count = options_for("samples.count", 6000);
  const double spacing = bake_points(scene, by_count, {}).points->attribute<double>("spacing");
  const OptionValues options = options_for("samples.spacing", spacing);
  const Sampled whole = bake_points(scene, options, {});
  const Sampled tiled = bake_points(scene, options, {60000, 2, 3});
  EXPECT_GT(tiled.thin_tasks, 1U);
  EXPECT_EQ(tiled.spacing, nullptr);
  expect_same(*whole.points, *tiled.points);
  EXPECT_LT(static_cast<double>(tiled.left), 1.5 * tiled.points->attribute<double>("samples"));
}

TEST(TilesOfAScene, NothingMetIsAUsersError) {
  const Scene scene = scene_named("closed_box");
  for (const char* key : {"samples.count", "samples.spacing"}) {
    OptionValues options = options_for(key, key == std::string("samples.count") ? 4200 : 0.08);
    options.set("samples.start", {1e6, 1e6, 1e6});
    EXPECT_THROW((void)bake_points(scene, options, {30000, 2, 3}), UserError) << key;
  }
}

}  // namespace
}  // namespace prt
