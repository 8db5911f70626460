#include "base/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "base/error.h"

namespace prt {
namespace {

/// Returns 0, or errno of what failed.
int write_synced(const std::string& path, std::span<const std::byte> bytes) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  int failure = 0;
  while (!bytes.empty() && failure == 0) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written >= 0) bytes = bytes.subspan(static_cast<std::size_t>(written));
    if (written < 0 && errno != EINTR) failure = errno;
  }
  // EINVAL: a file that cannot be synced, such as a pipe.
  if (failure == 0 && ::fsync(fd) != 0 && errno != EINVAL) failure = errno;
  if (::close(fd) != 0 && failure == 0) failure = errno;
  return failure;
}

void sync_folder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  static_cast<void>(::fsync(fd));
  ::close(fd);
}

}  // namespace

void write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const std::string temporary = path.string() + "." + std::to_string(::getpid()) + ".tmp";
  int failure = write_synced(temporary, bytes);
  if (failure == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) failure = errno;
  if (failure != 0) {
    ::unlink(temporary.c_str());
    throw UserError(path.string() + ": cannot be written: " + std::strerror(failure));
  }
  sync_folder(path.has_parent_path() ? path.parent_path() : ".");
}

}  // namespace prt
