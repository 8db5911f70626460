// All disk access of the store, behind an interface so that tests can inject faults.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace prt {

/// A disk operation failed. The message names the path, the reason and, where the user can do
/// something about it (disk full, read-only, no permission), the remedy.
class FileError : public UserError {
 public:
  /// `action` completes "cannot ...": "write", "read".
  FileError(const std::filesystem::path& path, const std::string& action, int error_number);
  [[nodiscard]] int error_number() const { return error_number_; }

 private:
  int error_number_;
};

/// A file being written, closed by its destructor. Bytes survive a crash of the machine only after
/// sync().
class WritableFile {
 public:
  virtual ~WritableFile() = default;
  virtual void append(std::span<const std::byte> bytes) = 0;
  /// Returns once the file's bytes are on the disk.
  virtual void sync() = 0;

  void append(std::string_view text) { append(std::as_bytes(std::span(text.data(), text.size()))); }
};

/// Held while it lives, and gone with its process however that ends.
class FileLock {
 public:
  virtual ~FileLock() = default;
};

/// Every member throws FileError on failure.
class FileSystem {
 public:
  using Path = std::filesystem::path;

  virtual ~FileSystem() = default;

  /// Creates the file, or empties it.
  virtual std::unique_ptr<WritableFile> create(const Path& path) = 0;
  /// Opens for writing at the end; creates the file if missing.
  virtual std::unique_ptr<WritableFile> open_append(const Path& path) = 0;
  /// Replaces `to` in one step. It survives a crash of the machine only after sync_dir.
  virtual void rename(const Path& from, const Path& to) = 0;
  virtual void sync_dir(const Path& dir) = 0;
  virtual std::vector<std::byte> read(const Path& path) = 0;
  /// Size of a regular file in bytes, or nothing if there is none.
  virtual std::optional<std::uint64_t> size(const Path& path) = 0;
  /// False if there was no such file.
  virtual bool remove(const Path& path) = 0;
  /// Names in a folder, sorted; none if there is no such folder.
  virtual std::vector<std::string> list(const Path& dir) = 0;
  /// The folder and those above it, as far as they are missing; they survive a crash of the
  /// machine.
  virtual void make_dirs(const Path& dir) = 0;
  /// An exclusive lock on the file (made if missing), or null while another process, or another
  /// lock of this one, holds it. The holder's `owner` text is left in the file for messages.
  virtual std::unique_ptr<FileLock> lock(const Path& path, const std::string& owner) = 0;
};

/// The disk, by POSIX calls.
class PosixFileSystem : public FileSystem {
 public:
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
};

/// Ends every temporary name; such files are left-overs once no bake runs.
inline constexpr std::string_view kTemporarySuffix = ".tmp";

/// Writes a whole file so that, whatever happens, either the old or the new one is there: temporary
/// name in the same folder, sync, re-read and compare, rename, sync of the folder. The temporary
/// file is removed on failure.
void replace_file(FileSystem& fs, const FileSystem::Path& path, std::span<const std::byte> bytes);

}  // namespace prt
