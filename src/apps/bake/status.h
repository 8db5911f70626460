// Tells onlookers in other processes how far the bake is: progress.json in its folder, replaced
// about once a second. Nothing depends on the file, so it is not synced and may fail.
//
//   {"finished": false, "seconds": 12.3, "text": "34 of 120 tasks; ...",
//    "ranks": {"busy": 2, "idle": 0, "lost": 0},
//    "stages": [{"stage": "rays", "total": 48, "done": 20, "found": 0}, ...]}
#pragma once

#include "jobs/coordinator.h"
#include "store/file_system.h"

namespace prt {

class StatusFile {
 public:
  StatusFile(FileSystem& fs, const FileSystem::Path& bake);
  /// Writes when a second has passed. `now`: any monotonic clock.
  void tick(const Coordinator& coordinator, double now);
  /// Writes that the bake is done.
  void finish(const Coordinator& coordinator);

 private:
  void write(const Coordinator& coordinator, bool finished);

  FileSystem& fs_;
  FileSystem::Path path_;
  double began_ = -1.0;
  double now_ = 0.0;
  double written_ = 0.0;
};

}  // namespace prt
