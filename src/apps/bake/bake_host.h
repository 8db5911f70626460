// The coordinating rank's side of a bake: plans, writes the manifest, lets artifacts go, shows
// progress.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "apps/bake/history.h"
#include "apps/bake/planner.h"
#include "apps/bake/progress.h"
#include "apps/bake/status.h"
#include "jobs/service.h"
#include "store/bake_folder.h"

namespace prt {

class Host : public BakeHost {
 public:
  /// Writes package, index and report; throws ResultDistrusted.
  using WriteResults = std::function<void(const Host& host, const FindResult& find)>;

  /// `history` gets a line for each task that is done. `keep_all`: no artifact is let go
  /// (store.keep).
  Host(Planner& planner, History& history, FileSystem& fs, BakeFolder& folder,
       WriteResults write_results, bool keep_all, int verbosity);

  void record(const Record& record) override;
  Event plan_on(const Coordinator& coordinator) override;
  std::optional<Event> finish(const Coordinator& coordinator) override;
  void tick(const Coordinator& coordinator, double now) override;

  [[nodiscard]] const BakePlan& plan() const { return plan_; }
  [[nodiscard]] const History& history() const { return history_; }

 private:
  void count_readers();
  void let_go(const std::string& task);
  void let_go_all();
  void sweep();

  Planner& planner_;
  BakeFolder& folder_;
  WriteResults write_results_;
  bool keep_all_;
  Progress progress_;
  StatusFile status_;
  History& history_;
  BakePlan plan_;
  std::size_t planned_ = 0;
  int lost_ = 0;
  bool any_was_lost_ = false;
  double now_ = 0.0;
  std::map<std::string, TaskSpec> specs_;
  std::map<std::string, std::size_t> unfinished_readers_;  // by task, once the plan is complete
  std::map<std::string, std::size_t> done_;                // task → place in the history
};

}  // namespace prt
