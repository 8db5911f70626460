// The folder of one bake: whose it is, who writes to it, and what is done.
#pragma once

#include <memory>
#include <string>

#include "store/artifact_store.h"
#include "store/manifest.h"

namespace prt {

/// Names in a bake's folder, beside artifacts/ and the manifest.
inline constexpr const char* kIndexName = "bake.h5";
inline constexpr const char* kLockName = "bake.lock";
/// How far a running bake is, for onlookers; nothing depends on it (apps/bake/status.h).
inline constexpr const char* kProgressName = "progress.json";

/// A folder that this process alone bakes into, as its coordinator; workers use an ArtifactStore of
/// their own on the same path.
class BakeFolder {
 public:
  /// Makes or re-opens the folder and locks it until destruction. `identity` says which bake this
  /// is: a folder of another identity, or one whose manifest is a foreign file, is refused with
  /// UserError unless `fresh`, which removes everything of ours first (and nothing else). UserError
  /// too if another bake holds the lock. Left-overs of killed bakes are removed.
  static BakeFolder open(FileSystem& fs, const FileSystem::Path& dir, const std::string& identity,
                         bool fresh);

  /// What the manifest held when the folder was opened.
  [[nodiscard]] const ManifestContents& found() const { return found_; }
  [[nodiscard]] ArtifactStore& store() { return *store_; }
  [[nodiscard]] ManifestWriter& manifest() { return *manifest_; }
  [[nodiscard]] const FileSystem::Path& path() const { return dir_; }

 private:
  BakeFolder() = default;

  FileSystem::Path dir_;
  std::unique_ptr<FileLock> lock_;
  std::unique_ptr<ArtifactStore> store_;
  ManifestContents found_;
  std::unique_ptr<ManifestWriter> manifest_;
};

/// A finished or unfinished bake to look at: nothing is locked or written. Throws UserError if the
/// folder holds no bake.
ManifestContents read_bake(FileSystem& fs, const FileSystem::Path& dir);

}  // namespace prt
