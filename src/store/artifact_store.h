// Artifacts on disk: one immutable file per finished task, artifacts/STAGE/KEY.h5.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "base/hash.h"
#include "store/artifact.h"
#include "store/file_system.h"
#include "store/hdf5_image.h"

namespace prt {

/// A task gave two different results for one KEY: the bake stops, for nothing can be trusted.
class DeterminismError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which code makes an artifact; goes into its file.
struct Origin {
  int code_version = 1;
  std::string equation = {};
};

/// Any number of processes and threads may use one folder. Every member throws FileError when the
/// disk fails. A stage is the task's kind.
class ArtifactStore {
 public:
  ArtifactStore(FileSystem& fs, FileSystem::Path bake_dir);

  [[nodiscard]] FileSystem::Path path(const std::string& stage, const Digest& key) const;
  [[nodiscard]] FileSystem::Path root() const { return bake_dir_ / "artifacts"; }

  /// Stores an artifact, on the disk and verified when this returns, and gives its content hash. An
  /// equal one that is there already is kept; throws DeterminismError if a sound one differs.
  Digest write(const std::string& stage, const Digest& key, const Artifact& artifact,
               const Origin& origin = {});
  /// Content hash of a sound file of that name. One that is corrupt, truncated or foreign is
  /// reported in the log and removed, so that it is made again.
  std::optional<Digest> check(const std::string& stage, const Digest& key);
  /// What the file says of itself, without datasets. Leaves an unsound file where it is and throws
  /// UnsoundData (missing files included).
  [[nodiscard]] LabelledArtifact head(const std::string& stage, const Digest& key) const;
  /// Throws UnsoundData if the file is missing, corrupt, foreign or has other content.
  [[nodiscard]] std::shared_ptr<const Artifact> read(const std::string& stage, const Digest& key,
                                                     const Digest& expected) const;
  /// Bytes of the file, 0 if there is none.
  [[nodiscard]] std::uint64_t bytes(const std::string& stage, const Digest& key) const;
  /// False if there was none.
  bool remove(const std::string& stage, const Digest& key);
  /// Removes left-overs of writes that were cut short. Only while no other bake writes here.
  void remove_temporaries();
  /// Removes every file of ours below artifacts/.
  void remove_all();

 private:
  using Parse = LabelledArtifact (*)(std::span<const std::byte> file);
  [[nodiscard]] LabelledArtifact load(const std::string& stage, const Digest& key,
                                      Parse parse) const;
  void make_stage(const std::string& stage);
  void remove_matching(bool (*matches)(const std::string& name));

  FileSystem& fs_;
  FileSystem::Path bake_dir_;
  std::mutex mutex_;
  std::set<std::string> made_stages_;  // guarded by mutex_
};

}  // namespace prt
