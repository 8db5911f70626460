// A prediction, made before anything is sampled, against the bake that then happens.
#include "apps/bake/prediction.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <stdexcept>
#include <thread>

#include "apps/bake/accuracy.h"
#include "apps/bake/time_limit.h"
#include "methods/lb/lb.h"
#include "scene/load.h"
#include "store/hdf5_image.h"
#include "support/in_process_bake.h"

namespace prt {
namespace {

/// samples.count is met within 5 %, and every sample casts the same rays.
constexpr double kCountTolerance = 0.05;
/// The goal of predictions. In seconds it depends on the machine's other work and is not tested.
constexpr double kBytesFactor = 1.5;
/// Of sums of a few seconds.
constexpr double kRounding = 1e-9;

BakeProgram program() {
  BakeProgram program;
  program.methods = {&lb_method()};
  program.make_ray_caster = make_embree_ray_caster;
  return program;
}

TEST(Prediction, MeetsRaysAndBytesOfTheBake) {
  const Scene scene = load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/gallery.glb");
  OptionValues options = test::default_options(lb_method());
  options.set("samples.count", 3000);
  options.set("samples.cluster_size", 300);
  options.set("rays.directions", 504);
  options.set("lb.example_lights", 200);
  const std::atomic<bool> stop = false;
  const auto prediction = predict_bake(program(), lb_method(), options, scene, "", stop);
  ASSERT_TRUE(prediction);

  test::InProcessBake bake(scene, options);
  const Plan plan = bake.run(lb_method());
  double rays = 0.0;
  double all = 0.0;
  for (const TaskSpec& task : plan.tasks) {
    const auto artifact = bake.result(task.id);
    if (task.kind == "rays") {
      rays += artifact->attribute<double>("samples") * artifact->attribute<double>("directions");
    }
    all += static_cast<double>(to_hdf5(*artifact, {task.kind, hash_text(task.id), 1, ""}).size());
  }
  for (const StagePrediction& stage : prediction->stages) {
    EXPECT_GE(stage.seconds, 0.0) << stage.stage;
    if (stage.stage == "rays") {
      EXPECT_NEAR(stage.rays, rays, kCountTolerance * rays);
    }
  }
  EXPECT_LT(prediction->total().bytes, kBytesFactor * all);
  EXPECT_GT(prediction->total().bytes, all / kBytesFactor);
  // Scaled to itself a bake takes what it took, and finer levels of effort take longer.
  const auto itself = scale_bake(program(), lb_method(), prediction->made, prediction->made.size,
                                 prediction->made.options);
  for (const StagePrediction& stage : itself) {
    EXPECT_NEAR(stage.seconds, prediction->made.stages.seconds(stage.stage), kRounding)
        << stage.stage;
  }
  double coarser = 0.0;
  for (int level = 0; level < lb_method().effort_levels(); ++level) {
    const double seconds = expected_seconds(program(), lb_method(), prediction->made,
                                            options_at(lb_method(), options, level), 2);
    EXPECT_GT(seconds, coarser) << level;
    coarser = seconds;
  }
  RecordProperty("bytes_ratio", std::to_string(prediction->total().bytes / all));
  EXPECT_LT(prediction->survey["colour_spread"].get<double>(), 1.0);
  EXPECT_EQ(prediction->survey["escaped_share"].get<double>(), 0.0);  // the gallery is closed
}

TEST(Prediction, SaysNothingOnceItIsStopped) {
  const Scene scene = load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/closed_box.glb");
  const std::atomic<bool> stop = true;
  const OptionValues options = test::default_options(lb_method());
  EXPECT_FALSE(predict_bake(program(), lb_method(), options, scene, "", stop));
}

TEST(PredictionBeside, HandsOverWhatItsThreadMadeAndKeepsQuietAboutFailures) {
  const auto bake = std::this_thread::get_id();
  PredictionBeside beside([&](const std::atomic<bool>&) {
    BakePrediction prediction;
    prediction.samples = std::this_thread::get_id() == bake ? 0.0 : 7.0;
    return std::optional(prediction);
  });
  for (int again = 0; again < 2; ++again) {
    ASSERT_NE(beside.get(), nullptr);
    EXPECT_EQ(beside.get()->samples, 7.0);
  }
  PredictionBeside failing([](const std::atomic<bool>&) -> std::optional<BakePrediction> {
    throw std::runtime_error("no");
  });
  EXPECT_EQ(failing.get(), nullptr);
}

TEST(PredictionBeside, IsGivenUpWithTheBake) {
  std::atomic<bool> given_up = false;
  {
    const PredictionBeside endless([&](const std::atomic<bool>& stop) {
      while (!stop) std::this_thread::yield();
      given_up = true;
      return std::optional<BakePrediction>();
    });
  }
  EXPECT_TRUE(given_up);
}

}  // namespace
}  // namespace prt
