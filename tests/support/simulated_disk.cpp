#include "support/simulated_disk.h"

#include <algorithm>
#include <cerrno>

#include "base/random.h"

namespace prt::test {

namespace {

/// What a file holds after the power was lost: as synced, all of it, cut short, or cut short with
/// zeros up to its length.
std::vector<std::byte> survivor(const std::vector<std::byte>& synced,
                                const std::vector<std::byte>& now, Random& random) {
  constexpr std::uint32_t kFates = 4;
  const std::uint32_t fate = random.below(kFates);
  if (fate == 0 || now == synced) return synced;
  if (fate == 1) return now;
  const bool appended =
      now.size() >= synced.size() && std::equal(synced.begin(), synced.end(), now.begin());
  const std::size_t sure = appended ? synced.size() : 0;
  const std::size_t cut = sure + random.below(static_cast<std::uint32_t>(now.size() - sure) + 1);
  std::vector<std::byte> torn(now.begin(), now.begin() + static_cast<std::ptrdiff_t>(cut));
  if (fate == 3) torn.resize(now.size());
  return torn;
}

}  // namespace

bool changes_disk(DiskCall call) {
  return call != DiskCall::kRead && call != DiskCall::kSize && call != DiskCall::kList;
}

class SimulatedDisk::Handle : public WritableFile {
 public:
  Handle(SimulatedDisk& disk, Path path, File file)
      : disk_(disk), path_(std::move(path)), file_(std::move(file)) {}
  void append(std::span<const std::byte> bytes) override { disk_.write(file_, path_, bytes); }
  void sync() override { disk_.sync(file_, path_); }

 private:
  SimulatedDisk& disk_;
  Path path_;
  File file_;
};

class SimulatedDisk::Lock : public FileLock {
 public:
  Lock(SimulatedDisk& disk, Path path) : disk_(disk), path_(std::move(path)) {}
  ~Lock() override {
    const std::scoped_lock guard(disk_.mutex_);
    disk_.locks_.erase(path_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  SimulatedDisk& disk_;
  Path path_;
};

SimulatedDisk::SimulatedDisk(const Path& root) : SimulatedDisk(Names{{root, nullptr}}) {}

void SimulatedDisk::ask(DiskCall kind, const Path& path) {
  if (!powered_) throw FileError(path, "reach", EIO);
  const bool counted = !path.filename().string().starts_with(uncounted);
  const Call call{kind, path, calls_};
  calls_ += counted ? 1 : 0;
  if (before) before(call);
}

void SimulatedDisk::require_folder(const Path& path) const {
  const auto found = names_.find(path);
  if (found == names_.end()) throw FileError(path, "write", ENOENT);
  if (found->second) throw FileError(path, "write", ENOTDIR);
}

SimulatedDisk::File SimulatedDisk::find(const Path& path) const {
  const auto found = names_.find(path);
  return found == names_.end() ? nullptr : found->second;
}

std::uint64_t SimulatedDisk::used() const {
  std::uint64_t sum = 0;
  for (const auto& [name, file] : names_) sum += file ? file->now.size() : 0;
  return sum;
}

void SimulatedDisk::apply(const Change& change) {
  if (!change.gone.empty()) names_.erase(change.gone);
  if (!change.made.empty()) names_[change.made] = change.file;
  const Path& any = change.made.empty() ? change.gone : change.made;
  unsynced_[any.parent_path()].push_back(change);
}

void SimulatedDisk::lose_power() {
  const std::scoped_lock guard(mutex_);
  powered_ = false;
}

std::shared_ptr<SimulatedDisk> SimulatedDisk::after_outage(std::uint64_t seed) const {
  const std::scoped_lock guard(mutex_);
  Random random(stream_key(seed, "outage"), 0);
  Names left = synced_names_;
  for (const auto& [dir, changes] : unsynced_) {
    for (const Change& change : changes) {
      if (random.below(2) == 0) continue;
      if (!change.gone.empty()) left.erase(change.gone);
      if (!change.made.empty()) left[change.made] = change.file;
    }
  }
  for (auto& [name, file] : left) {
    if (!file) continue;
    const Bytes bytes = survivor(file->synced, file->now, random);
    file = std::make_shared<Content>(Content{bytes, bytes, 0, 0});
  }
  return std::shared_ptr<SimulatedDisk>(new SimulatedDisk(std::move(left)));
}

std::map<std::string, std::vector<std::byte>> SimulatedDisk::files() const {
  const std::scoped_lock guard(mutex_);
  std::map<std::string, Bytes> files;
  for (const auto& [name, file] : names_) {
    if (file) files[name.string()] = file->now;
  }
  return files;
}

std::unique_ptr<WritableFile> SimulatedDisk::create(const Path& path) {
  const std::scoped_lock guard(mutex_);
  const auto make = [&] {
    require_folder(path.parent_path());
    // Emptying a file keeps what was synced, until the next sync.
    if (const File old = find(path)) {
      *old = {{}, old->synced, 0, 0};
    } else {
      apply({{}, path, std::make_shared<Content>()});
    }
  };
  try {
    ask(DiskCall::kCreate, path);
  } catch (...) {
    if (powered_ && failed_calls_happen && names_.contains(path.parent_path())) make();
    throw;
  }
  make();
  return std::make_unique<Handle>(*this, path, find(path));
}

std::unique_ptr<WritableFile> SimulatedDisk::open_append(const Path& path) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kOpen, path);
  require_folder(path.parent_path());
  if (!find(path)) apply({{}, path, std::make_shared<Content>()});
  return std::make_unique<Handle>(*this, path, find(path));
}

void SimulatedDisk::write(const File& file, const Path& path, std::span<const std::byte> bytes) {
  const std::scoped_lock guard(mutex_);
  const auto put = [&](std::size_t count) {
    file->now.insert(file->now.end(), bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(count));
  };
  try {
    ask(DiskCall::kWrite, path);
  } catch (...) {
    if (powered_) put(bytes.size() / 2);
    throw;
  }
  const std::uint64_t in_use = used();
  const std::uint64_t room = capacity > in_use ? capacity - in_use : 0;
  if (bytes.size() > room) {
    put(room);
    throw FileError(path, "write", ENOSPC);
  }
  put(bytes.size());
}

void SimulatedDisk::sync(const File& file, const Path& path) {
  const std::scoped_lock guard(mutex_);
  try {
    ask(DiskCall::kSync, path);
  } catch (...) {
    if (file->lost_to == 0) file->lost_from = file->synced.size();
    file->lost_to = file->now.size();
    throw;
  }
  file->synced = file->now;
  for (std::size_t i = file->lost_from; i < std::min(file->lost_to, file->now.size()); ++i) {
    file->synced[i] = std::byte{0};
  }
}

void SimulatedDisk::rename(const Path& from, const Path& to) {
  const std::scoped_lock guard(mutex_);
  const auto move = [&] {
    const File file = find(from);
    if (!file) throw FileError(to, "write", ENOENT);
    apply({from, to, file});
  };
  try {
    ask(DiskCall::kRename, to);
  } catch (...) {
    if (powered_ && failed_calls_happen && find(from)) move();
    throw;
  }
  move();
}

void SimulatedDisk::sync_dir(const Path& dir) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kSyncDir, dir);
  require_folder(dir);
  for (const Change& change : unsynced_[dir]) {
    if (!change.gone.empty()) synced_names_.erase(change.gone);
    if (!change.made.empty()) synced_names_[change.made] = change.file;
  }
  unsynced_.erase(dir);
}

std::vector<std::byte> SimulatedDisk::read(const Path& path) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kRead, path);
  const File file = find(path);
  if (!file) throw FileError(path, "read", names_.contains(path) ? EISDIR : ENOENT);
  return file->now;
}

std::optional<std::uint64_t> SimulatedDisk::size(const Path& path) {
  const std::scoped_lock guard(mutex_);
  try {
    ask(DiskCall::kSize, path);
  } catch (const FileError& error) {
    if (error.error_number() == ENOENT) return std::nullopt;
    throw;
  }
  const File file = find(path);
  return file ? std::optional<std::uint64_t>(file->now.size()) : std::nullopt;
}

bool SimulatedDisk::remove(const Path& path) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kRemove, path);
  if (!find(path)) return false;
  apply({path, {}, nullptr});
  return true;
}

std::vector<std::string> SimulatedDisk::list(const Path& dir) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kList, dir);
  std::vector<std::string> found;
  for (const auto& [name, file] : names_) {
    if (name.parent_path() == dir) found.push_back(name.filename());
  }
  std::ranges::sort(found);
  return found;
}

void SimulatedDisk::make_dirs(const Path& dir) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kMakeDirs, dir);
  Path path;
  for (const Path& part : dir) {
    path /= part;
    if (path == path.root_path()) continue;
    const auto found = names_.find(path);
    if (found != names_.end() && found->second) {
      throw FileError(dir, "make the folder", ENOTDIR);
    }
    names_[path] = nullptr;
    synced_names_[path] = nullptr;
  }
}

std::unique_ptr<FileLock> SimulatedDisk::lock(const Path& path, const std::string& owner) {
  const std::scoped_lock guard(mutex_);
  ask(DiskCall::kLock, path);
  require_folder(path.parent_path());
  if (!locks_.insert(path).second) return nullptr;
  if (!find(path)) apply({{}, path, std::make_shared<Content>()});
  const auto text = std::as_bytes(std::span(owner.data(), owner.size()));
  find(path)->now.assign(text.begin(), text.end());
  return std::make_unique<Lock>(*this, path);
}

}  // namespace prt::test
