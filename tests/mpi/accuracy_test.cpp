// Accuracy as the input, as a user meets it: level after level until the measured error is below
// the goal, killed in between; and a time limit beside it.
#include "apps/bake/accuracy.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "methods/lb/lb.h"
#include "support/in_process_bake.h"
#include "support/program.h"

namespace prt {
namespace {

using nlohmann::json;

constexpr double kGoal = 0.07;

json error_of(double rel_rmse, double standard_error, double light_error, double visibility) {
  return {
      {"indirect",
       {{"rel_rmse", rel_rmse}, {"standard_error", standard_error}, {"light_error", light_error}}},
      {"visibility_error", visibility}};
}

TEST(AccuracyGoal, CountsAnErrorWithItsStandardErrorAndTheWorstFigure) {
  OptionValues options = test::default_options(lb_method());
  EXPECT_FALSE(AccuracyGoal(options).wanted());
  options.set("accuracy.indirect", 0.1);
  const AccuracyGoal indirect(options);
  EXPECT_NEAR(indirect.excess(error_of(0.05, 0.03, 0.04, 0.9)), 1.0, 1e-12);
  EXPECT_GT(indirect.excess(error_of(0.09, 0.03, 0.04, 0.0)), 1.0);
  options.set("accuracy.visibility", 0.02);
  EXPECT_NEAR(AccuracyGoal(options).excess(error_of(0.05, 0.0, 0.0, 0.04)), 2.0, 1e-12);
}

TEST(AccuracyGoal, LevelsGoUpToTheFinestAndNoFarther) {
  const Method& method = lb_method();
  const int last = method.effort_levels() - 1;
  EXPECT_EQ(next_level(method, 0, 1.01), 1);
  EXPECT_EQ(next_level(method, 0, 3.0), 2);  // 0.6² = 0.36 is what two levels leave at best
  EXPECT_EQ(next_level(method, 1, 1e6), last);
  EXPECT_EQ(next_level(method, last, 2.0), last);
  const OptionValues options = test::default_options(method);
  for (int level = 0; level < last; ++level) {
    EXPECT_LT(options_at(method, options, level).get<int>("samples.count"),
              options_at(method, options, level + 1).get<int>("samples.count"));
  }
  // What a level asks for is what a user could have asked for.
  for (int level = 0; level <= last; ++level) {
    const OptionValues at = options_at(method, options, level);
    for (const auto& spec : method.options()) check_option(spec, at.at(spec.key), "level");
    for (const auto& spec : shared_options()) {
      if (at.is_set(spec.key)) check_option(spec, at.at(spec.key), "level");
    }
  }
}

class AccuracyBake : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<test::Program> start(int ranks,
                                                     const std::vector<std::string>& settings = {
                                                         "accuracy.indirect=" +
                                                         std::to_string(kGoal)}) const {
    const std::string source = PRT_SOURCE_DIR;
    test::BakeRun run;
    run.ranks = ranks;
    run.more = {"--out", bake().string()};
    for (const std::string& setting : settings) {
      run.more.insert(run.more.end(), {"--set", setting});
    }
    return test::start_bake(
        {std::string(PRT_BINARY_DIR) + "/bin/prt_bake", source + "/configs/default.yaml", "--set",
         "scene=" + source + "/configs/scenes/cornell.glb"},
        run, PRT_MPIRUN, folder_.path / "log.txt");
  }
  [[nodiscard]] test::fs::path bake() const { return folder_.path / "room"; }

  test::TemporaryFolder folder_;
};

TEST_F(AccuracyBake, RefinesUntilTheGoalIsMetAcrossAKill) {
  const auto first = start(1);
  constexpr std::size_t kSome = 120;  // the first level is done
  while (test::count_artifacts(bake()) < kSome && !first->finished()) std::this_thread::yield();
  ASSERT_FALSE(first->finished()) << first->output();
  first->kill_all();

  const auto resumed = start(2);
  ASSERT_EQ(resumed->wait(), 0) << resumed->output();
  EXPECT_EQ(resumed->output().find(" 0 found, "), std::string::npos) << "nothing was resumed";
  const json report = json::parse(test::read_text(bake() / "report.json"));
  const json& accuracy = report["accuracy"];
  EXPECT_TRUE(accuracy["met"].get<bool>());
  EXPECT_NE(test::read_text(bake() / "report.html").find("Accuracy asked for"), std::string::npos);
  ASSERT_GE(accuracy["levels"].size(), 2U) << "the coarsest level was enough to test anything";
  EXPECT_GT(accuracy["levels"].front()["indirect"].get<double>(), kGoal);
  EXPECT_LE(report["error"]["indirect"]["rel_rmse"].get<double>(), kGoal);
  // The package is that of the last level.
  EXPECT_EQ(report["options"]["samples.count"], accuracy["levels"].back()["samples"]);
  EXPECT_EQ(report["error"]["indirect"]["rel_rmse"], accuracy["levels"].back()["indirect"]);

  const auto before = test::read_text(bake() / "room.prt.glb");
  const auto again = start(0);
  ASSERT_EQ(again->wait(), 0) << again->output();
  EXPECT_NE(again->output().find("already done"), std::string::npos) << again->output();
  EXPECT_TRUE(test::read_text(bake() / "room.prt.glb") == before);

  const std::string inspect = std::string(PRT_BINARY_DIR) + "/bin/prt_inspect";
  test::Program verify({inspect, bake().string(), "--verify"}, folder_.path / "verify.txt");
  EXPECT_EQ(verify.wait(), 0) << verify.output();
  // Tasks go by their names without a level, those of the last.
  test::Program draw({inspect, bake().string(), "--image", "rank", "-o", folder_.path / "rank.png"},
                     folder_.path / "draw.txt");
  EXPECT_EQ(draw.wait(), 0) << draw.output();
  EXPECT_NE(test::read_text(bake() / "report.html").find("<b>Ranks</b>"), std::string::npos);
}

TEST_F(AccuracyBake, ATimeLimitTooShortForAnythingBakesTheCoarsestAndSaysSo) {
  const auto limited = start(2, {"time_limit=0.1", "accuracy.indirect=" + std::to_string(kGoal)});
  ASSERT_EQ(limited->wait(), 0) << limited->output();
  EXPECT_NE(limited->output().find("too short for the coarsest level"), std::string::npos)
      << limited->output();
  EXPECT_NE(limited->output().find("NOT met within the time limit"), std::string::npos);
  const json report = json::parse(test::read_text(bake() / "report.json"));
  const json& limit = report["time_limit"];
  EXPECT_FALSE(limit["met"].get<bool>());
  EXPECT_FALSE(report["accuracy"]["met"].get<bool>());
  ASSERT_EQ(limit["levels"].size(), 1U);
  EXPECT_GT(limit["levels"][0]["seconds"].get<double>(), 0.1);
  // What the next would have taken, from the stages of this one: a dearer one.
  EXPECT_GT(limit["next_seconds"].get<double>(), limit["levels"][0]["seconds"].get<double>());
  EXPECT_EQ(limit["levels"][0]["indirect"], report["error"]["indirect"]["rel_rmse"]);

  // With the goal within reach of the coarsest there is nothing to choose.
  const auto easy = start(1, {"time_limit=1e6", "accuracy.indirect=1"});
  ASSERT_EQ(easy->wait(), 0) << easy->output();
  const json met = json::parse(test::read_text(bake() / "report.json"));
  EXPECT_TRUE(met["accuracy"]["met"].get<bool>());
  EXPECT_TRUE(met["time_limit"]["met"].get<bool>());
  EXPECT_EQ(met["time_limit"]["level"], 0);
}

}  // namespace
}  // namespace prt
