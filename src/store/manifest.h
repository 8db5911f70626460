// The log of a bake: append-only, one checksummed text line per finished task, so that a resume
// knows what is done without opening an artifact.
//
// A choice that hung on a clock is a line, too: a resume repeats it.
//
// A line is "CHECKSUM JSON\n", CHECKSUM the XXH3-128 of the JSON text in hexadecimal. The first
// line is a header with the schema version and the identity of the bake. A line that is torn or
// damaged is skipped: the artifact it told of is found again by its KEY.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/hash.h"
#include "store/file_system.h"

namespace prt {

/// Of the lines and of the artifacts they tell of. An older bake's lines count for nothing: its
/// artifacts are made again.
inline constexpr int kManifestSchemaVersion = 2;
inline constexpr const char* kManifestName = "manifest.log";

/// Ends the level in front of a task's id where a bake has levels of effort: "2:rays/0007".
inline constexpr char kLevelEnd = ':';
/// "2:" of "2:rays/0007", nothing of "rays/0007".
inline std::string level_of(const std::string& task) {
  return task.substr(0, task.find(kLevelEnd) + 1);  // npos + 1 is 0
}

/// A finished task.
struct ManifestEntry {
  std::string task;      ///< task id
  std::string kind;      ///< also the stage
  Digest key;            ///< KEY of design §4
  Digest content;        ///< content hash of the artifact
  double seconds = 0.0;  ///< wall time of the task
  double cpu_seconds = 0.0;
  std::uint64_t bytes = 0;    ///< of the artifact's file
  int rank = 0;               ///< that ran it
  std::int64_t finished = 0;  ///< Unix time, s
  friend bool operator==(const ManifestEntry&, const ManifestEntry&) = default;
};

/// Which level of effort comes after one, chosen by the time that was left.
struct LevelChoice {
  Digest bake;             ///< of all settings that decide which levels there are
  int after = 0;           ///< the level that was done
  int level = 0;           ///< that comes next; `after` itself: none, for no other fits
  double predicted = 0.0;  ///< seconds that it is to take; where none comes, the next finer one
  double used = 0.0;       ///< seconds that the bake had taken when it was chosen
  friend bool operator==(const LevelChoice&, const LevelChoice&) = default;
};

struct ManifestContents {
  bool exists = false;                 ///< there is a file
  bool has_header = false;             ///< with a sound header
  bool outdated = false;               ///< of an older schema; has no entries then
  std::string identity;                ///< of the bake; empty without a header
  std::vector<ManifestEntry> entries;  ///< one per task: the last; in the order of first lines
  /// All lines that tell of the making, not the finding of an artifact: a task that goes back to
  /// settings of before finds what it took then.
  std::vector<ManifestEntry> made;
  std::vector<LevelChoice> choices;  ///< in the order they were taken
  std::size_t damaged_lines = 0;
};

/// Reads a manifest; damaged lines are counted and warned of, never fatal. Throws UserError for a
/// schema version newer than ours.
ManifestContents read_manifest(FileSystem& fs, const FileSystem::Path& path);

/// Makes a manifest of a header, entries and choices, replacing what is there.
void create_manifest(FileSystem& fs, const FileSystem::Path& path, const std::string& identity,
                     const std::vector<ManifestEntry>& entries = {},
                     const std::vector<LevelChoice>& choices = {});

/// Appends lines; only the coordinator does. Not thread-safe.
class ManifestWriter {
 public:
  /// Opens for appending; starts a new line if the last one is torn.
  ManifestWriter(FileSystem& fs, const FileSystem::Path& path);
  /// Syncs what is left, and keeps quiet about failures: call sync() to hear of them.
  ~ManifestWriter();
  ManifestWriter(const ManifestWriter&) = delete;
  ManifestWriter& operator=(const ManifestWriter&) = delete;

  /// Writes the line at once; it is on the disk after the next sync. `now`: any monotonic clock, s.
  void append(const ManifestEntry& entry, double now);
  /// The same, and it is on the disk when this returns: what is chosen shows at once.
  void append(const LevelChoice& choice);
  /// Syncs if lines have waited kSyncInterval or longer. Call it whenever idle.
  void sync_if_due(double now);
  void sync();

  static constexpr double kSyncInterval = 0.5;  ///< s

 private:
  std::unique_ptr<WritableFile> file_;
  bool unsynced_ = false;
  double oldest_unsynced_ = 0.0;
};

}  // namespace prt
