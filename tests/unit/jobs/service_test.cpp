#include "jobs/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "jobs/messages.h"

namespace prt {
namespace {

/// Rank 0 of several; keeps what it sends.
class RecordingLink : public Link {
 public:
  explicit RecordingLink(int ranks) : ranks_(ranks) {}
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return ranks_; }
  void send(WorkerId to, std::string text) override { sent[to].push_back(std::move(text)); }
  std::optional<Message> poll() override { return std::nullopt; }

  std::map<WorkerId, std::vector<std::string>> sent;

 private:
  int ranks_;
};

TEST(Service, RanksThatNeverSaidAWordAreSentHomeToo) {
  RecordingLink link(3);
  dismiss_all(link, ExitCode::kInterrupted);
  ASSERT_EQ(link.sent.size(), 2U);
  for (const WorkerId rank : {1, 2}) {
    ASSERT_EQ(link.sent[rank].size(), 1U);
    const Order order = decode_order(link.sent[rank][0]);
    ASSERT_TRUE(std::holds_alternative<Dismissed>(order));
    EXPECT_EQ(std::get<Dismissed>(order).code, ExitCode::kInterrupted);
  }
}

}  // namespace
}  // namespace prt
