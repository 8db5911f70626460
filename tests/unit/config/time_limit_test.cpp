// A time limit as the input, with a toy whose tasks take one second each on a clock of the test's:
// 16, 31 and 61 s for its three levels.
#include "apps/bake/time_limit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/time.h>

#include <atomic>
#include <fstream>

#include "apps/bake/bake_session.h"
#include "base/error.h"
#include "base/log.h"
#include "support/program.h"
#include "support/toy_method.h"

namespace prt {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(FinestFitting, TakesTheFinestThatFitsWithSomeToSpare) {
  const std::vector<double> seconds{10.0, 25.0, 60.0};
  EXPECT_EQ(finest_fitting(0, seconds, 1000.0).level, 3);
  EXPECT_EQ(finest_fitting(0, seconds, 61.0).level, 2) << "a second is not enough to spare";
  EXPECT_EQ(finest_fitting(2, seconds, 40.0).level, 4);
  EXPECT_DOUBLE_EQ(finest_fitting(2, seconds, 40.0).seconds, 25.0);
  EXPECT_EQ(finest_fitting(2, seconds, 9.0).level, 2);
  EXPECT_DOUBLE_EQ(finest_fitting(2, seconds, 9.0).seconds, 10.0);
  EXPECT_EQ(finest_fitting(5, {}, 1e9).level, 5);
}

TEST(SecondsOn, AStageOfFewTasksKeepsFewThreadsBusy) {
  const std::vector<StagePrediction> stages{{"many", 100, 0, 64.0, 0, 0}, {"one", 1, 0, 3.0, 0, 0}};
  EXPECT_DOUBLE_EQ(seconds_on(1, stages), 67.0);
  EXPECT_DOUBLE_EQ(seconds_on(8, stages), 11.0);
}

constexpr double kRounding = 1e-6;

struct Ended {
  ExitCode code = ExitCode::kDone;
  std::string said;
};

class TimedBake : public testing::Test {
 protected:
  TimedBake() {
    std::ofstream(folder_.path / "toy.scene") << "a triangle";
    std::ofstream(folder_.path / "toy.yaml") << "scene: toy.scene\noutput: bake\nmethods: [toy]\n";
  }
  ~TimedBake() override { log::set_up(-1); }

  Ended bake(const std::vector<std::string>& settings, bool plan_only = false) {
    BakeProgram program = test::toy_program_with_levels([this](const std::string& task) {
      if (task == fails_at_) throw UserError("stopped at " + task);
      clock_ = clock_ + 1.0;
    });
    program.clock = [this] { return clock_.load(); };
    BakeCommand command;
    command.config = folder_.path / "toy.yaml";
    command.overrides.settings = settings;
    command.threads = 1;
    command.plan_only = plan_only;
    log::set_up(0);
    const auto ranks = make_single_rank();
    Ended ended;
    testing::internal::CaptureStderr();
    ended.code = prt::bake(command, program, *ranks);
    const itimerval no_timer{};
    setitimer(ITIMER_REAL, &no_timer, nullptr);  // the limit of a failed program's farewell
    ended.said = testing::internal::GetCapturedStderr();
    return ended;
  }
  [[nodiscard]] std::string text(const std::string& file) const {
    return test::read_text(folder_.path / "bake" / file);
  }
  [[nodiscard]] json report() const { return json::parse(text("report.json")); }
  [[nodiscard]] std::vector<int> levels() const {
    std::vector<int> all;
    const json limit = report()["time_limit"];
    for (const json& level : limit["levels"]) all.push_back(level["level"]);
    return all;
  }

  test::TemporaryFolder folder_;
  std::atomic<double> clock_ = 100.0;
  std::string fails_at_;
};

TEST_F(TimedBake, MakesTheFinestLevelThatFits) {
  const Ended ended = bake({"time_limit=70"});
  EXPECT_EQ(ended.code, ExitCode::kDone) << ended.said;
  EXPECT_EQ(levels(), (std::vector{0, 1}));
  const json limit = report()["time_limit"];
  EXPECT_TRUE(limit["met"].get<bool>());
  EXPECT_EQ(limit["level"], 1);
  EXPECT_NEAR(limit["used_seconds"], 47.0, kRounding);
  EXPECT_NEAR(limit["predicted_seconds"], 16.0 + 32.0, kRounding);
  EXPECT_NEAR(limit["next_seconds"], 62.0, kRounding);
  EXPECT_NEAR(limit["levels"][0]["seconds"], 16.0, kRounding);
  EXPECT_NEAR(limit["levels"][1]["seconds"], 31.0, kRounding);
  EXPECT_EQ(report()["options"]["toy.leaves"], 20);
  EXPECT_THAT(text("report.html"), HasSubstr("met with level 1 after 47.00 s"));
  EXPECT_THAT(ended.said, HasSubstr("time limit 70.0 s: level 1 in 47.0 s"));

  // The clock chose the level, and no byte beside.
  const std::string package = text("bake.prt.glb");
  EXPECT_EQ(bake({"toy.leaves=20", "toy.values=200"}).code, ExitCode::kDone);
  EXPECT_TRUE(text("bake.prt.glb") == package);
}

TEST_F(TimedBake, SkipsLevelsThatAFinerOneMakesNeedless) {
  EXPECT_EQ(bake({"time_limit=1000"}).code, ExitCode::kDone);
  EXPECT_EQ(levels(), (std::vector{0, 2}));
  EXPECT_TRUE(report()["time_limit"]["next_seconds"].is_null());
}

TEST_F(TimedBake, FinishesTheCoarsestLevelAndSaysByHowMuchItIsLate) {
  const Ended ended = bake({"time_limit=5"});
  EXPECT_EQ(ended.code, ExitCode::kDone) << ended.said;
  EXPECT_EQ(levels(), std::vector{0});
  EXPECT_FALSE(report()["time_limit"]["met"].get<bool>());
  EXPECT_THAT(ended.said, HasSubstr("too short for the coarsest level: 16.0 s, 11.0 s over"));
  EXPECT_THAT(text("report.html"), HasSubstr("<b>not met</b>: level 0, the coarsest,"));
}

TEST_F(TimedBake, AResumeRepeatsNoChoice) {
  fails_at_ = "1:leaf/0003";
  EXPECT_EQ(bake({"time_limit=70"}).code, ExitCode::kBadInput);
  fails_at_.clear();
  // What is found takes no time on this clock: chosen anew, the finest level would fit.
  EXPECT_EQ(bake({"time_limit=70"}).code, ExitCode::kDone);
  EXPECT_EQ(levels().at(1), 1);
  const std::string package = text("bake.prt.glb");
  const double before = clock_;
  EXPECT_THAT(bake({"time_limit=70"}).said, HasSubstr("already done"));
  EXPECT_EQ(clock_, before);
  EXPECT_TRUE(text("bake.prt.glb") == package);
  // Another limit is another bake's choice, and the report tells of it even if nothing is made.
  EXPECT_EQ(bake({"time_limit=1000"}).code, ExitCode::kDone);
  EXPECT_EQ(levels(), (std::vector{0, 2}));
}

TEST_F(TimedBake, APlanChoosesNothing) {
  fails_at_ = "1:leaf/0003";
  EXPECT_EQ(bake({"time_limit=70"}).code, ExitCode::kBadInput);
  const std::string manifest = text("manifest.log");
  testing::internal::CaptureStdout();
  EXPECT_EQ(bake({"time_limit=1000"}, true).code, ExitCode::kDone);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("planned from what these measure"));
  EXPECT_TRUE(text("manifest.log") == manifest);
}

TEST_F(TimedBake, AMethodWithoutLevelsIsRefused) {
  BakeProgram program = test::toy_program();
  BakeCommand command;
  command.config = folder_.path / "toy.yaml";
  command.overrides.settings = {"time_limit=10"};
  const auto ranks = make_single_rank();
  testing::internal::CaptureStderr();
  EXPECT_EQ(prt::bake(command, program, *ranks), ExitCode::kBadInput);
  const itimerval no_timer{};
  setitimer(ITIMER_REAL, &no_timer, nullptr);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("time_limit: the method toy"));
}

}  // namespace
}  // namespace prt
