#include "apps/inspect/bake_reader.h"

namespace prt {

BakeReader::BakeReader(FileSystem& fs, const FileSystem::Path& dir)
    : fs_(fs), dir_(dir), manifest_(read_bake(fs, dir)), store_(fs, dir) {
  const std::string level = manifest_.made.empty() ? "" : level_of(manifest_.made.back().task);
  for (ManifestEntry entry : manifest_.entries) {
    if (level_of(entry.task) != level) continue;
    entry.task.erase(0, level.size());
    entry_of_task_[entry.task] = entry;
    entries_.push_back(std::move(entry));
  }
}

std::shared_ptr<const Artifact> BakeReader::artifact(const std::string& task) const {
  const auto it = entry_of_task_.find(task);
  if (it == entry_of_task_.end()) {
    throw UserError(dir_.string() + ": no finished task " + task + " in this bake");
  }
  const ManifestEntry& entry = it->second;
  if (is_missing(entry)) {
    throw UserError(dir_.string() + ": the artifact of " + task +
                    " is not kept; bake with --set store.keep=all");
  }
  return store_.read(entry.kind, entry.key, entry.content);
}

bool BakeReader::is_missing(const ManifestEntry& entry) const {
  return store_.bytes(entry.kind, entry.key) == 0;
}

}  // namespace prt
