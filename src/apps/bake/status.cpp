#include "apps/bake/status.h"

#include "apps/bake/progress.h"
#include "base/log.h"
#include "store/bake_folder.h"

namespace prt {

namespace {
constexpr double kEverySeconds = 1.0;
}

StatusFile::StatusFile(FileSystem& fs, const FileSystem::Path& bake)
    : fs_(fs), path_(bake / kProgressName) {}

void StatusFile::tick(const Coordinator& coordinator, double now) {
  now_ = now;
  if (began_ < 0.0) {
    began_ = now;
  } else if (now - written_ < kEverySeconds) {
    return;
  }
  written_ = now;
  write(coordinator, false);
}

void StatusFile::finish(const Coordinator& coordinator) { write(coordinator, true); }

void StatusFile::write(const Coordinator& coordinator, bool finished) {
  nlohmann::json stages = nlohmann::json::array();
  for (const auto& [name, stage] : coordinator.progress()) {
    stages.push_back(
        {{"stage", name}, {"total", stage.total}, {"done", stage.done}, {"found", stage.adopted}});
  }
  const RankCounts ranks = coordinator.ranks();
  const double seconds = began_ < 0.0 ? 0.0 : now_ - began_;
  const nlohmann::json status = {
      {"finished", finished},
      {"seconds", seconds},
      {"text", progress_text(coordinator, seconds)},
      {"ranks", {{"busy", ranks.busy}, {"idle", ranks.idle}, {"lost", ranks.lost}}},
      {"stages", stages}};
  const FileSystem::Path temporary = path_.string() + std::string(kTemporarySuffix);
  try {
    fs_.create(temporary)->append(std::string_view(status.dump() + "\n"));
    fs_.rename(temporary, path_);
  } catch (const FileError& e) {
    log::debug("{}", e.what());
  }
}

}  // namespace prt
