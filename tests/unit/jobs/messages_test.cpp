#include "jobs/messages.h"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "graph.h"

namespace prt {
namespace {

TEST(Messages, AnAssignmentSurvivesTheWire) {
  const std::string odd = "rays/\"\\\n\xc3\xa4";  // nothing of ours, and JSON's trouble
  TaskSpec task = test::make_task("transfer/0001", {"rays/0001", odd}, 0.1);
  task.version = 7;
  task.scene_parts = kGeometry | kMaterials;
  task.parameters = {{"tolerance", 1e-3}, {"cluster", 1}, {"point", {0.1, 2.0, -3.5}}};
  Assignment a{task, hash_text("key"), hash_text("expected"), {}};
  a.inputs.push_back({"rays/0001", "rays", hash_text("k"), hash_text("c")});
  a.inputs.push_back({odd, "rays", hash_text("l"), hash_text("d")});

  const auto b = std::get<Assignment>(decode_order(encode_order(a)));
  const auto all = [](const TaskSpec& t) {
    return std::tie(t.id, t.kind, t.version, t.parameters, t.inputs, t.scene_parts, t.cost);
  };
  EXPECT_TRUE(all(b.task) == all(a.task));
  EXPECT_EQ(task_key(b.task, {hash_text("c")}, {}), task_key(a.task, {hash_text("c")}, {}));
  EXPECT_EQ(b.key, a.key);
  EXPECT_EQ(b.expected, a.expected);
  ASSERT_EQ(b.inputs.size(), 2U);
  EXPECT_EQ(b.inputs[0].id, "rays/0001");
  EXPECT_EQ(b.inputs[0].stage, "rays");
  EXPECT_EQ(b.inputs[0].key, hash_text("k"));
  EXPECT_EQ(b.inputs[0].content, hash_text("c"));
}

TEST(Messages, ReportsSurviveTheWire) {
  const TaskDone sent{3,
                      "rays/1",
                      hash_text("k"),
                      hash_text("c"),
                      true,
                      {12.5, 0.25, 0.2, 4096, 1},
                      {{"error", 0.5}}};
  const auto done = std::get<TaskDone>(decode_report(encode_report(sent)));
  EXPECT_EQ(done.worker, 3);
  EXPECT_EQ(done.key, sent.key);
  EXPECT_EQ(done.content, sent.content);
  EXPECT_TRUE(done.adopted);
  EXPECT_EQ(done.cost.bytes, 4096U);
  EXPECT_DOUBLE_EQ(done.cost.began, 12.5);
  EXPECT_EQ(done.figures, sent.figures);
  const auto failed =
      std::get<TaskFailed>(decode_report(encode_report(TaskFailed{1, "a", "why \xff", true})));
  EXPECT_TRUE(failed.user_error);
  EXPECT_EQ(std::get<InputUnsound>(decode_report(encode_report(InputUnsound{1, "a", "b"}))).input,
            "b");
  EXPECT_EQ(std::get<WorkerJoined>(decode_report(encode_report(WorkerJoined{2, 4}))).slots, 4);
  EXPECT_EQ(std::get<Heartbeat>(decode_report(encode_report(Heartbeat{9}))).worker, 9);
  EXPECT_TRUE(
      std::holds_alternative<DrainRequested>(decode_report(encode_report(DrainRequested{}))));
  EXPECT_TRUE(std::holds_alternative<StillHere>(decode_order(encode_order(StillHere{}))));
  EXPECT_EQ(std::get<Dismissed>(decode_order(encode_order(Dismissed{ExitCode::kInterrupted}))).code,
            ExitCode::kInterrupted);
}

TEST(Messages, RubbishIsUnsound) {
  for (const char* text : {"", "[]", "{", "{\"type\":\"nobody\"}", "{\"type\":\"done\"}",
                           "{\"type\":\"assign\",\"task\":3}"}) {
    EXPECT_THROW(decode_order(text), UnsoundData) << text;
    EXPECT_THROW(decode_report(text), UnsoundData) << text;
  }
}

}  // namespace
}  // namespace prt
