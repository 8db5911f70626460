#include "store/file_system.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <random>
#include <utility>

#include "base/log.h"

namespace prt {

namespace {

using Path = FileSystem::Path;

const char* remedy(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return "; free some space and run the same command again";
    case EROFS:
    case EACCES:
    case EPERM:
      return "; make it accessible or choose another folder";
    default:
      return "";
  }
}

/// Owns a file descriptor.
class Descriptor {
 public:
  Descriptor(const Path& path, const char* action, int flags)
      : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (fd_ < 0) throw FileError(path, action, errno);
  }
  ~Descriptor() { ::close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

void write_all(int fd, std::span<const std::byte> bytes, const Path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw FileError(path, "write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void sync_descriptor(int fd, const Path& path) {
  // Folders of some network file systems cannot be synced, and need not be.
  if (::fsync(fd) != 0 && errno != EINVAL) throw FileError(path, "write", errno);
}

class PosixFile : public WritableFile {
 public:
  PosixFile(const Path& path, int flags)
      : path_(path), descriptor_(path, "write", O_WRONLY | O_CREAT | flags) {}
  void append(std::span<const std::byte> bytes) override {
    write_all(descriptor_.fd(), bytes, path_);
  }
  void sync() override { sync_descriptor(descriptor_.fd(), path_); }

 private:
  Path path_;
  Descriptor descriptor_;
};

class PosixLock : public FileLock {
 public:
  explicit PosixLock(const Path& path) : descriptor_(path, "write", O_RDWR | O_CREAT) {}
  [[nodiscard]] int fd() const { return descriptor_.fd(); }

 private:
  Descriptor descriptor_;
};

}  // namespace

FileError::FileError(const Path& path, const std::string& action, int error_number)
    : UserError(path.string() + ": cannot " + action + ": " + std::strerror(error_number) +
                remedy(error_number)),
      error_number_(error_number) {}

std::unique_ptr<WritableFile> PosixFileSystem::create(const Path& path) {
  return std::make_unique<PosixFile>(path, O_TRUNC);
}

std::unique_ptr<WritableFile> PosixFileSystem::open_append(const Path& path) {
  return std::make_unique<PosixFile>(path, O_APPEND);
}

void PosixFileSystem::rename(const Path& from, const Path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw FileError(to, "write", errno);
}

void PosixFileSystem::sync_dir(const Path& dir) {
  const Descriptor descriptor(dir, "write", O_RDONLY | O_DIRECTORY);
  sync_descriptor(descriptor.fd(), dir);
}

std::vector<std::byte> PosixFileSystem::read(const Path& path) {
  const Descriptor descriptor(path, "read", O_RDONLY);
  struct stat status {};
  if (::fstat(descriptor.fd(), &status) != 0) throw FileError(path, "read", errno);
  if (S_ISDIR(status.st_mode)) throw FileError(path, "read", EISDIR);
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(descriptor.fd(), bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw FileError(path, "read", errno);
    if (got == 0) break;  // became shorter meanwhile
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

std::optional<std::uint64_t> PosixFileSystem::size(const Path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
    throw FileError(path, "read", errno);
  }
  if (!S_ISREG(status.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(status.st_size);
}

bool PosixFileSystem::remove(const Path& path) {
  if (::unlink(path.c_str()) == 0) return true;
  if (errno == ENOENT || errno == ENOTDIR) return false;
  throw FileError(path, "remove", errno);
}

std::vector<std::string> PosixFileSystem::list(const Path& dir) {
  const std::unique_ptr<DIR, int (*)(DIR*)> stream(::opendir(dir.c_str()), ::closedir);
  if (!stream) {
    if (errno == ENOENT || errno == ENOTDIR) return {};
    throw FileError(dir, "read", errno);
  }
  std::vector<std::string> names;
  errno = 0;
  while (const dirent* entry = ::readdir(stream.get())) {
    const std::string name = entry->d_name;
    if (name != "." && name != "..") names.push_back(name);
  }
  if (errno != 0) throw FileError(dir, "read", errno);
  std::sort(names.begin(), names.end());
  return names;
}

void PosixFileSystem::make_dirs(const Path& dir) {
  std::error_code error;
  if (std::filesystem::is_directory(dir, error)) return;
  const Path parent = dir.parent_path();
  if (!parent.empty() && parent != dir) make_dirs(parent);
  if (::mkdir(dir.c_str(), 0777) != 0) {
    // Another rank may have been faster.
    const int reason = errno == EEXIST ? ENOTDIR : errno;
    if (errno == EEXIST && std::filesystem::is_directory(dir, error)) return;
    throw FileError(dir, "make the folder", reason);
  }
  sync_dir(parent.empty() ? Path(".") : parent);
}

std::unique_ptr<FileLock> PosixFileSystem::lock(const Path& path, const std::string& owner) {
  auto lock = std::make_unique<PosixLock>(path);
  // A lock of the open file, not of the process: the kernel drops it with the process, so a killed
  // bake leaves no stale lock, and two locks of one process exclude each other, too.
  struct flock request {};
  request.l_type = F_WRLCK;
  request.l_whence = SEEK_SET;
  if (::fcntl(lock->fd(), F_OFD_SETLK, &request) != 0) {
    if (errno == EAGAIN || errno == EACCES) return nullptr;
    if (errno != ENOLCK && errno != EOPNOTSUPP && errno != ENOSYS && errno != EINVAL) {
      throw FileError(path, "lock", errno);
    }
    log::warn("{}: this file system keeps no locks; run one bake at a time here", path.string());
  }
  if (::ftruncate(lock->fd(), 0) != 0) throw FileError(path, "write", errno);
  write_all(lock->fd(), std::as_bytes(std::span(owner.data(), owner.size())), path);
  return lock;
}

void replace_file(FileSystem& fs, const Path& path, std::span<const std::byte> bytes) {
  // Unique among ranks on any host; names of temporary files reach no result.
  std::random_device random;
  const Path temporary = path.string() + "." + std::to_string(::getpid()) + "." +
                         std::to_string(random()) + std::string(kTemporarySuffix);
  try {
    const auto file = fs.create(temporary);
    file->append(bytes);
    file->sync();
    const auto read = fs.read(temporary);
    if (read.size() != bytes.size() ||
        (!read.empty() && std::memcmp(read.data(), bytes.data(), read.size()) != 0)) {
      throw FileError(path, "write (what was read back differs)", EIO);
    }
    fs.rename(temporary, path);
  } catch (...) {
    try {
      fs.remove(temporary);
    } catch (const FileError&) {  // the first failure is the one to tell
    }
    throw;
  }
  fs.sync_dir(path.parent_path().empty() ? Path(".") : path.parent_path());
}

}  // namespace prt
