// Parts of the bake service that need no bake: CPU limits, agreement, history, report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "apps/bake/agreement.h"
#include "apps/bake/command_line.h"
#include "apps/bake/cpu_share.h"
#include "apps/bake/history.h"
#include "apps/bake/progress.h"
#include "apps/bake/report.h"
#include "base/error.h"
#include "base/image_file.h"

namespace prt {
namespace {

using testing::HasSubstr;

TEST(CpuShare, ReadsQuotas) {
  EXPECT_EQ(cpus_of_quota("150000 100000"), 2);
  EXPECT_EQ(cpus_of_quota("50000 100000"), 1);
  EXPECT_EQ(cpus_of_quota("max 100000"), 0);
  EXPECT_EQ(cpus_of_quota("-1 100000"), 0);
  EXPECT_EQ(cpus_of_quota(""), 0);
}

TEST(CpuShare, EveryRankHasAtLeastOneThread) {
  EXPECT_GE(share_cpus(1).threads, 1);
  EXPECT_EQ(share_cpus(10'000).threads, 1);
}

TEST(Agreement, PassesOnWhatAStepThrows) {
  const auto ranks = make_single_rank();
  EXPECT_NO_THROW(do_together(*ranks, [] {}));
  EXPECT_THROW(do_together(*ranks, [] { throw UserError("x"); }), UserError);
  EXPECT_THROW(do_together(*ranks, [] { throw std::runtime_error("x"); }), std::runtime_error);
}

TEST(Agreement, TheLowestInstructionSetWins) {
  EXPECT_EQ(lowest_isa({"avx512", "avx2", "avx512"}), "avx2");
  EXPECT_EQ(lowest_isa({"avx", "sse4.2"}), "sse4.2");
  EXPECT_TRUE(can_run("avx512", "avx2"));
  EXPECT_FALSE(can_run("avx2", "avx512"));
}

Record made(const std::string& task, double began, double seconds, bool adopted,
            const Digest& key) {
  TaskDone done;
  done.task = task;
  done.key = key;
  done.adopted = adopted;
  done.cost.began = began;
  done.cost.seconds = seconds;
  return {done, "rays", adopted};
}

TEST(History, FoundTasksKeepTheCostOfMakingThem) {
  ManifestEntry entry;
  entry.key = hash_text("a");
  entry.seconds = 4.0;
  entry.finished = 104;
  entry.rank = 3;
  ManifestEntry overlapping = entry;
  overlapping.key = hash_text("b");
  overlapping.finished = 106;
  History history({entry, overlapping});
  history.add(made("rays/0", 500.0, 0.01, true, hash_text("a")));
  history.add(made("rays/1", 500.0, 0.01, true, hash_text("b")));
  history.add(made("rays/2", 500.0, 2.0, false, hash_text("c")));
  EXPECT_EQ(history.made(), 1U);
  EXPECT_EQ(history.tasks()[0].rank, 3);
  EXPECT_DOUBLE_EQ(history.tasks()[0].cost.seconds, 4.0);
  // 100 to 104 and 102 to 106.
  EXPECT_DOUBLE_EQ(history.earlier_seconds(), 6.0);
  const auto trace = nlohmann::json::parse(chrome_trace(history.tasks()));
  EXPECT_EQ(trace["traceEvents"].size(), 1U);
}

TEST(Report, PageEscapesAndShowsEverything) {
  const nlohmann::json stage = {{"stage", "rays"},
                                {"tasks", 3},
                                {"made", 2},
                                {"found", 1},
                                {"seconds", 1.5},
                                {"cpu_seconds", 1.4},
                                {"bytes", 1000},
                                {"predicted_seconds", 2.25},
                                {"predicted_bytes", nullptr},
                                {"measured", {{"lost", {{"mean", 0.001}, {"max", 0.002}}}}}};
  const nlohmann::json report = {
      {"package", "<a>.prt.glb"},
      {"package_bytes", 2'000'000},
      {"bake_seconds", 3.0},
      {"scene", {{"file", "a & b.glb"}, {"triangles", 5}, {"repairs", 0}}},
      {"method", "lb"},
      {"error", {{"indirect", {{"rel_rmse", 0.04}}}}},
      {"stages", {stage}},
      {"survey", {{"mean_albedo", 0.375}}},
      {"left_out", {{{"what", "two channels"}, {"reason", "grey"}}}},
      {"this_run", {{"ranks", 2}}},
      {"options", {{"seed", 1}}}};
  const std::vector<std::uint8_t> grey(3 * 16 * 16, 128);
  const ReportPicture picture{"<room>", "lit", encode_jpeg(16, 16, grey, 85), "1 %", "2 %"};
  const nlohmann::json budget = {
      {"base", {{"indirect", 0.04}}},
      {"rows", {{{"what", "<density>"}, {"indirect_finer", 0.03}, {"indirect_share", -0.4}}, 7}}};
  const std::string page = report_page(report, {picture}, budget);
  // What report_page_in_browser loads.
  std::ofstream(std::string(PRT_BINARY_DIR) + "/report_page_test.html") << page;
  EXPECT_THAT(page, HasSubstr("&lt;room&gt;"));
  EXPECT_THAT(page, HasSubstr("&lt;density&gt;"));
  EXPECT_THAT(page, HasSubstr("-40.00"));
  EXPECT_THAT(page, HasSubstr("&lt;a&gt;.prt.glb"));
  EXPECT_THAT(page, HasSubstr("a &amp; b.glb"));
  EXPECT_THAT(page, HasSubstr("indirect.rel_rmse"));
  EXPECT_THAT(page, HasSubstr("lost 0.001 (max 0.002)"));
  EXPECT_THAT(page, HasSubstr("<td>2.25</td><td>1.50</td>"));
  EXPECT_THAT(page, HasSubstr("<td>–</td>"));
  EXPECT_THAT(page, HasSubstr("<th>mean_albedo</th><td>0.375</td>"));
  EXPECT_THAT(page, HasSubstr("two channels"));
  EXPECT_THAT(page, testing::Not(HasSubstr("http")));
}

TEST(Progress, TellsStagesRateAndTimeLeft) {
  Coordinator c({}, {});
  TaskSpec a, b;
  a.id = "rays/0";
  b.id = "rays/1";
  a.kind = b.kind = "rays";
  b.parameters = {{"c", 1}};
  (void)c.handle(TasksAdded{{a, b}, true});
  TaskDone done;
  done.task = "rays/0";
  done.key = task_key(a, {}, {});
  (void)c.handle(done);
  EXPECT_EQ(progress_text(c, 2.0), "1 of 2 tasks; rays 1/2 0.5/s; about 2 s");
}

TEST(CommandLine, ParsesTheContract) {
  std::string message;
  const char* words[] = {"prt_bake", "a.yaml", "--set",   "seed=3",    "--set", "lb.solver=photons",
                         "--out",    "d",      "--fresh", "--threads", "2",     "--trace",
                         "t.json",   "-v"};
  const auto c = parse_bake_command(std::size(words), const_cast<char**>(words), {}, message);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->config, "a.yaml");
  EXPECT_THAT(c->overrides.settings, testing::ElementsAre("seed=3", "lb.solver=photons"));
  EXPECT_EQ(c->overrides.output, "d");
  EXPECT_TRUE(c->fresh);
  EXPECT_FALSE(c->plan_only);
  EXPECT_EQ(c->threads, 2);
  EXPECT_EQ(c->verbosity, 1);
}

TEST(CommandLine, RefusesNonsenseInOneLine) {
  const std::vector<std::vector<const char*>> cases = {{"prt_bake"},
                                                       {"prt_bake", "a.yaml", "--threads", "0"},
                                                       {"prt_bake", "a.yaml", "--threads", "x"},
                                                       {"prt_bake", "a.yaml", "--nonsense"},
                                                       {"prt_bake", "a.yaml", "b.yaml"},
                                                       {"prt_bake", "a.yaml", "-v", "-q"},
                                                       {"prt_bake", "a.yaml", "--set"}};
  for (const auto& words : cases) {
    std::string message;
    try {
      parse_bake_command(static_cast<int>(words.size()), const_cast<char**>(words.data()), {},
                         message);
      ADD_FAILURE() << words.back();
    } catch (const UserError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace prt
