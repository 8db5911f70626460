// A disk in memory that fails as real ones do: any call may fail, writes go only part of the way,
// and what was not synced may be gone or torn after the power was lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "store/file_system.h"

namespace prt::test {

enum class DiskCall {
  kCreate,
  kOpen,
  kWrite,
  kSync,
  kRename,
  kSyncDir,
  kRead,
  kSize,
  kRemove,
  kList,
  kMakeDirs,
  kLock
};

/// True for calls that change the disk.
bool changes_disk(DiskCall call);

/// The rules, each at least as hard as those of a local journalling file system or NFS:
/// - A file's bytes survive a loss of power as they were at its last sync; later ones survive, are
///   missing, or end in the middle, by chance, and what is missing may read as zeros.
/// - Names survive as they were when their folder was last synced; each later change to a folder
///   (a rename is one change) survives or not by chance, independent of the others.
/// - A write that fails may have written its first half; a rename or creation that fails may have
///   happened; what a failed sync should have saved can be read on, but no later sync saves it.
class SimulatedDisk : public FileSystem {
 public:
  struct Call {
    DiskCall kind;
    Path path;
    std::size_t number;  ///< of calls so far
  };

  /// `root` exists.
  explicit SimulatedDisk(const Path& root);

  /// Asked before each call; a FileError or other exception that it throws fails the call.
  std::function<void(const Call&)> before;
  /// Whether a creation or rename that fails has happened all the same.
  bool failed_calls_happen = false;
  /// Calls on files whose name begins so are not counted: those that come by the clock.
  std::string uncounted = "no such name";
  /// Bytes of all files together, locks aside; a write beyond fails with ENOSPC.
  std::uint64_t capacity = std::numeric_limits<std::uint64_t>::max();

  /// From now on every call fails.
  void lose_power();
  /// What a loss of power leaves of this disk, by chance of `seed`; one outage has many outcomes.
  [[nodiscard]] std::shared_ptr<SimulatedDisk> after_outage(std::uint64_t seed) const;

  [[nodiscard]] std::size_t calls() const { return calls_; }
  /// All files as a program would read them.
  [[nodiscard]] std::map<std::string, std::vector<std::byte>> files() const;

  std::unique_ptr<WritableFile> create(const Path& path) override;
  std::unique_ptr<WritableFile> open_append(const Path& path) override;
  void rename(const Path& from, const Path& to) override;
  void sync_dir(const Path& dir) override;
  std::vector<std::byte> read(const Path& path) override;
  std::optional<std::uint64_t> size(const Path& path) override;
  bool remove(const Path& path) override;
  std::vector<std::string> list(const Path& dir) override;
  void make_dirs(const Path& dir) override;
  std::unique_ptr<FileLock> lock(const Path& path, const std::string& owner) override;

 private:
  using Bytes = std::vector<std::byte>;
  struct Content {
    Bytes now;                  ///< as programs read it
    Bytes synced;               ///< as it survives
    std::size_t lost_from = 0;  ///< what a failed sync has dropped: [lost_from, lost_to)
    std::size_t lost_to = 0;
  };
  using File = std::shared_ptr<Content>;
  /// Null: a folder.
  using Names = std::map<Path, File>;
  /// A change of names not yet on the disk: `gone` goes and `made` comes.
  struct Change {
    Path gone;
    Path made;
    File file;
  };
  class Handle;
  class Lock;

  explicit SimulatedDisk(Names names) : names_(std::move(names)), synced_names_(names_) {}
  void ask(DiskCall kind, const Path& path);
  void require_folder(const Path& path) const;
  void apply(const Change& change);
  [[nodiscard]] File find(const Path& path) const;
  [[nodiscard]] std::uint64_t used() const;
  void write(const File& file, const Path& path, std::span<const std::byte> bytes);
  void sync(const File& file, const Path& path);

  mutable std::recursive_mutex mutex_;  // `before` may call back
  Names names_;
  Names synced_names_;
  std::map<Path, std::vector<Change>> unsynced_;  ///< by folder, in order
  std::set<Path> locks_;
  std::size_t calls_ = 0;
  bool powered_ = true;
};

}  // namespace prt::test
