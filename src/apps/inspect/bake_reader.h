// A bake as prt_inspect sees it: the manifest and the artifacts it names, read only.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "store/artifact_store.h"
#include "store/bake_folder.h"

namespace prt {

class BakeReader {
 public:
  /// Throws UserError if the folder holds no bake.
  BakeReader(FileSystem& fs, const FileSystem::Path& dir);

  [[nodiscard]] const ManifestContents& manifest() const { return manifest_; }
  /// Its entries but those of other levels of effort than the one that was made last; ids without
  /// the level.
  [[nodiscard]] const std::vector<ManifestEntry>& entries() const { return entries_; }
  [[nodiscard]] const ArtifactStore& store() const { return store_; }
  [[nodiscard]] const FileSystem::Path& path() const { return dir_; }
  [[nodiscard]] FileSystem& file_system() const { return fs_; }

  /// The artifact of a finished task. Throws UserError that names the task if it is not finished or
  /// was let go, UnsoundData if it cannot be trusted.
  [[nodiscard]] std::shared_ptr<const Artifact> artifact(const std::string& task) const;
  /// True if the artifact is gone although its task is finished.
  [[nodiscard]] bool is_missing(const ManifestEntry& entry) const;

 private:
  FileSystem& fs_;
  FileSystem::Path dir_;
  ManifestContents manifest_;
  ArtifactStore store_;
  std::vector<ManifestEntry> entries_;
  std::map<std::string, ManifestEntry> entry_of_task_;
};

}  // namespace prt
