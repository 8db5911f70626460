// What the method plans: pure, sound, keyed by what each task reads, and no more than is needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "methods/lb/lb.h"
#include "methods/lb/regions.h"
#include "methods/lb/scene_part.h"
#include "scene/load.h"
#include "statistical/test_scenes.h"
#include "support/partial_bake.h"

namespace prt {
namespace {

OptionValues tiny_bake() {
  OptionValues options = test::default_options(lb_method());
  options.set("samples.count", 300);
  options.set("samples.cluster_size", 75);
  options.set("rays.directions", 64);
  options.set("lb.example_lights", 40);
  options.set("lb.light_rank", 3);
  return options;
}

const Scene& closed_box() {
  static const Scene scene =
      load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/closed_box.glb");
  return scene;
}

void expect_same(const Plan& a, const Plan& b) {
  ASSERT_EQ(a.tasks.size(), b.tasks.size());
  for (std::size_t i = 0; i < a.tasks.size(); ++i) {
    const TaskSpec& s = a.tasks[i];
    const TaskSpec& t = b.tasks[i];
    EXPECT_EQ(s.id, t.id);
    EXPECT_EQ(s.kind, t.kind);
    EXPECT_EQ(s.version, t.version);
    EXPECT_EQ(s.parameters, t.parameters);
    EXPECT_EQ(s.inputs, t.inputs);
    EXPECT_EQ(s.scene_parts, t.scene_parts);
    EXPECT_EQ(s.cost, t.cost);
  }
  EXPECT_EQ(a.complete, b.complete);
  EXPECT_EQ(a.results, b.results);
  EXPECT_EQ(a.left_out.size(), b.left_out.size());
}

/// Keys of all tasks as a bake makes them, but that a changed key stands for changed content.
std::map<std::string, Digest> keys_of(const Plan& plan, const Scene& scene) {
  std::map<std::string, Digest> keys;
  const SceneHashes hashes{scene.geometry_hash, scene.materials_hash, scene.lights_hash};
  for (const TaskSpec& task : plan.tasks) {
    std::vector<Digest> inputs;
    for (const auto& id : task.inputs) inputs.push_back(keys.at(id));
    keys[task.id] = task_key(task, inputs, hashes);
  }
  return keys;
}

bool left_out(const Plan& plan, const std::string& what) {
  return std::any_of(plan.left_out.begin(), plan.left_out.end(),
                     [&](const LeftOut& l) { return l.what == what && !l.reason.empty(); });
}

class LbPlan : public ::testing::TestWithParam<const char*> {};

TEST_P(LbPlan, IsPureAndSoundAtEveryStage) {
  OptionValues options = tiny_bake();
  if (std::string(GetParam()) == "regions") {
    options.set("lb.region_clusters", 2);
  } else {
    options.set("lb.solver", GetParam());
  }
  test::InProcessBake bake(closed_box(), options);
  const auto kinds = lb_method().kinds();
  Plan before;
  for (int stage = 0; stage < 20; ++stage) {
    const Plan plan = lb_method().plan(bake);
    expect_same(plan, lb_method().plan(bake));
    std::map<std::string, std::size_t> place;
    for (const TaskSpec& task : plan.tasks) {
      EXPECT_TRUE(std::find(kinds.begin(), kinds.end(), task.kind) != kinds.end()) << task.kind;
      for (const auto& input : task.inputs) {
        EXPECT_TRUE(place.contains(input)) << task.id << " wants " << input << " before it is made";
      }
      EXPECT_TRUE(place.emplace(task.id, place.size()).second) << task.id << " twice";
      EXPECT_GT(task.cost, 0.0);
      EXPECT_NE(lb_method().equation(task.kind).find("LB §4"), std::string::npos) << task.kind;
    }
    // Known tasks are repeated unchanged.
    for (const TaskSpec& known : before.tasks) {
      ASSERT_TRUE(place.contains(known.id)) << known.id << " was forgotten";
      EXPECT_EQ(plan.tasks[place.at(known.id)].parameters, known.parameters);
      EXPECT_EQ(plan.tasks[place.at(known.id)].inputs, known.inputs);
    }
    if (plan.complete) {
      for (const auto& id : plan.results) EXPECT_TRUE(place.contains(id)) << id;
      return;
    }
    for (const TaskSpec& task : plan.tasks) {
      if (!bake.result(task.id)) bake.run_task(lb_method(), task);
    }
    before = plan;
  }
  ADD_FAILURE() << "the plan is never complete";
}
INSTANTIATE_TEST_SUITE_P(Ways, LbPlan, ::testing::Values("gather", "photons", "regions"));

TEST(LbRegions, NameNoMoreInputsThanTheirWindowsHave) {
  OptionValues options = tiny_bake();
  options.set("samples.cluster_size", 20);
  options.set("lb.region_clusters", 3);
  options.set("lb.window_tolerance", 0.5);
  test::InProcessBake bake(closed_box(), options);
  const Plan plan = bake.run(lb_method());
  const auto regions = lb::get_regions(*bake.result(lb::kWindowsTask));
  const std::size_t clusters =
      bake.result("samples")->values<std::uint32_t>("cluster_begin").size() - 1;
  std::size_t solves = 0;
  for (const TaskSpec& task : plan.tasks) {
    if (!task.parameters.contains("region")) continue;
    EXPECT_EQ(task.inputs.back(), lb::kWindowsTask) << task.id;
    const Region& region = regions.at(task.parameters["region"].get<std::size_t>());
    ASSERT_LT(region.window.size(), clusters);
    const auto named = [&](const std::string& stage) {
      return static_cast<std::size_t>(std::ranges::count_if(
          task.inputs, [&](const std::string& id) { return id.starts_with(stage + "/"); }));
    };
    const std::map<std::string, std::string> reads = {
        {"transfer", "near"}, {"residual", "transfer"}, {"solve", "galerkin"}};
    const auto read = reads.find(task.kind);
    if (read == reads.end()) continue;
    EXPECT_EQ(named(read->second), region.window.size()) << task.id;
    solves += task.kind == "solve" ? 1 : 0;
  }
  EXPECT_EQ(solves, regions.size());  // the box is grey
}

TEST(LbRegions, WhoCastsAClustersRaysWorksInItsWindow) {
  OptionValues options = tiny_bake();
  options.set("samples.cluster_size", 20);
  options.set("lb.region_clusters", 3);
  test::InProcessBake bake(closed_box(), options);
  const Plan plan = bake.run(lb_method());
  const auto regions = lb::get_regions(*bake.result(lb::kWindowsTask));
  ASSERT_GT(regions.size(), 1U);
  std::map<std::size_t, std::size_t> region_of;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    for (const std::uint32_t c : regions[r].clusters) region_of[c] = r;
  }
  std::map<std::string, std::size_t> placed;
  for (const TaskSpec& task : plan.tasks) {
    if (!task.parameters.contains("cluster")) continue;
    const auto cluster = task.parameters["cluster"].get<std::size_t>();
    EXPECT_EQ(task.place, lb::Regions::place(region_of.at(cluster))) << task.id;
    ++placed[task.kind];
  }
  for (const char* kind : {"rays", "reach", "near", "light_basis", "transfer"}) {
    EXPECT_EQ(placed[kind], region_of.size()) << kind;
  }
}

TEST(LbKeys, ChangedMaterialsCastNoRayAgain) {
  test::InProcessBake bake(closed_box(), tiny_bake());
  const Plan plan = bake.run(lb_method());
  Scene painted = closed_box();
  painted.materials_hash = hash_text("another albedo");
  const auto before = keys_of(plan, closed_box());
  const auto after = keys_of(plan, painted);
  std::set<std::string> changed;
  for (const TaskSpec& task : plan.tasks) {
    if (before.at(task.id) != after.at(task.id)) changed.insert(task.kind);
  }
  for (const char* kind :
       {"start", "candidates", "points", "cells", "samples", "rays", "visibility", "lights"}) {
    EXPECT_FALSE(changed.contains(kind)) << kind;
  }
  EXPECT_TRUE(changed.contains("albedo"));
  EXPECT_TRUE(changed.contains("transfer"));
}

TEST(LbKeys, ChangedGeometryMakesAllAnew) {
  test::InProcessBake bake(closed_box(), tiny_bake());
  const Plan plan = bake.run(lb_method());
  Scene moved = closed_box();
  moved.geometry_hash = hash_text("another shape");
  const auto before = keys_of(plan, closed_box());
  const auto after = keys_of(plan, moved);
  for (const auto& [id, key] : before) EXPECT_NE(key, after.at(id)) << id;
}

TEST(LbKeys, ChangedLightRankCastsNoRayAgain) {
  OptionValues more = tiny_bake();
  more.set("lb.light_rank", 4);
  test::InProcessBake bake(closed_box(), tiny_bake());
  test::InProcessBake other(closed_box(), more);
  const auto before = keys_of(bake.run(lb_method()), closed_box());
  const auto after = keys_of(other.run(lb_method()), closed_box());
  int rays = 0;
  for (const auto& [id, key] : before) {
    const std::string kind = id.substr(0, id.find('/'));
    if (kind != "rays" && kind != "samples" && kind != "visibility" && kind != "lights") continue;
    EXPECT_EQ(key, after.at(id)) << id;
    rays += kind == "rays" ? 1 : 0;
  }
  EXPECT_GT(rays, 1);
  EXPECT_NE(before.at("light_functions"), after.at("light_functions"));
}

Scene box_of(const Vec3f& albedo) {
  Scene scene;
  test::add_box(scene, Vec3f::Constant(-1.0F), Vec3f::Constant(1.0F),
                test::add_material(scene, albedo));
  test::finish(scene);
  return scene;
}

void expect_no_transport(const Scene& scene, const OptionValues& options) {
  test::InProcessBake bake(scene, options);
  const Plan plan = bake.run(lb_method());
  EXPECT_TRUE(left_out(plan, "transport"));
  for (const TaskSpec& task : plan.tasks) {
    EXPECT_EQ(task.kind.find("transfer"), std::string::npos) << task.kind;
    EXPECT_NE(task.kind, "snapshot");
    EXPECT_NE(task.kind, "light_basis");
  }
}

TEST(LbPlanner, LeavesOutTransportWhereAllIsBlack) {
  expect_no_transport(box_of(Vec3f::Zero()), tiny_bake());
}

TEST(LbPlanner, LeavesOutTransportWhereNoBounceIsWanted) {
  for (const char* solver : {"gather", "photons"}) {
    OptionValues options = tiny_bake();
    options.set("lb.solver", solver);
    options.set("transport.bounces", 0);
    expect_no_transport(closed_box(), options);
  }
}

std::set<int> channels_of(const Scene& scene) {
  test::InProcessBake bake(scene, tiny_bake());
  const Plan plan = bake.run(lb_method());
  std::set<int> channels;
  for (const TaskSpec& task : plan.tasks) {
    if (task.kind == "transfer") channels.insert(task.parameters["channels"].get<int>());
  }
  EXPECT_EQ(left_out(plan, "two colour channels"), channels == std::set<int>{1});
  return channels;
}

TEST(LbPlanner, TakesOneChannelWhereAllIsGrey) {
  EXPECT_EQ(channels_of(closed_box()), std::set<int>{1});
  EXPECT_EQ(channels_of(box_of({0.5F, 0.4F, 0.3F})), std::set<int>{3});
}

TEST(Plan, NearTransferIsMoreThanSixMeanRays) {
  for (const auto& [directions, share] : {std::pair{2016, 0.003}, {64, 6.0 / 64}}) {
    OptionValues options = tiny_bake();
    options.set("rays.directions", directions);
    test::InProcessBake bake(closed_box(), options);
    test::run_kinds(bake, lb_method(), test::kSamplingAndRays);
    const Plan plan = lb_method().plan(bake);
    std::size_t seen = 0;
    for (const TaskSpec& task : plan.tasks) {
      if (task.kind != "near" && task.kind != "light_basis") continue;
      EXPECT_DOUBLE_EQ(task.parameters["near_share"].get<double>(), share) << task.id;
      ++seen;
    }
    EXPECT_GT(seen, 0U);
    const bool said = std::ranges::any_of(
        plan.left_out, [](const LeftOut& l) { return l.what.starts_with("near transfer"); });
    EXPECT_EQ(said, directions == 64);
  }
}

}  // namespace
}  // namespace prt
