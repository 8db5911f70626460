#include "store/bake_folder.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <thread>

#include "base/log.h"

namespace prt {

namespace {

constexpr const char* kRemedy = "; use --fresh or another --out";

std::string this_process() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return "process " + std::to_string(::getpid()) + " on " + host.data();
}

/// A killed bake's lock goes with its last process, which takes the kernel a moment.
constexpr std::chrono::milliseconds kLockPatience{2000};
constexpr std::chrono::milliseconds kLockInterval{50};

std::unique_ptr<FileLock> take_lock(FileSystem& fs, const FileSystem::Path& dir) {
  const auto path = dir / kLockName;
  const auto until = std::chrono::steady_clock::now() + kLockPatience;
  do {
    if (auto lock = fs.lock(path, this_process())) return lock;
    std::this_thread::sleep_for(kLockInterval);
  } while (std::chrono::steady_clock::now() < until);
  const auto owner = fs.read(path);
  throw UserError(dir.string() + ": another bake is writing here (" +
                  std::string(reinterpret_cast<const char*>(owner.data()), owner.size()) +
                  "); wait for it to end or use another --out");
}

/// Removes what a bake makes, the manifest first: without it nothing else counts as done.
void remove_bake(FileSystem& fs, const FileSystem::Path& dir, ArtifactStore& store) {
  fs.remove(dir / kManifestName);
  fs.remove(dir / kIndexName);
  fs.remove(dir / kProgressName);
  store.remove_all();
}

/// True if the header must be written (again).
bool needs_header(const ManifestContents& found, const FileSystem::Path& dir, bool has_artifacts,
                  const std::string& identity) {
  if (!found.exists) return true;
  if (found.has_header) {
    if (found.identity != identity) {
      throw UserError(dir.string() + ": holds another bake (" + found.identity + ")" + kRemedy);
    }
    if (found.outdated) {
      log::info("{}: made by an older prtbake; its artifacts will be made again", dir.string());
    }
    return found.outdated;
  }
  if (found.entries.empty() && !has_artifacts) {
    throw UserError((dir / kManifestName).string() + ": is no manifest of a bake" + kRemedy);
  }
  log::warn(
      "{}: the header is damaged; taken for this bake, as every artifact is checked by its "
      "key",
      (dir / kManifestName).string());
  return true;
}

}  // namespace

BakeFolder BakeFolder::open(FileSystem& fs, const FileSystem::Path& dir,
                            const std::string& identity, bool fresh) {
  BakeFolder folder;
  folder.dir_ = dir;
  fs.make_dirs(dir);
  folder.lock_ = take_lock(fs, dir);
  folder.store_ = std::make_unique<ArtifactStore>(fs, dir);
  if (fresh) remove_bake(fs, dir, *folder.store_);
  const auto manifest = dir / kManifestName;
  folder.found_ = read_manifest(fs, manifest);
  const bool has_artifacts = !fs.list(folder.store_->root()).empty();
  if (needs_header(folder.found_, dir, has_artifacts, identity)) {
    create_manifest(fs, manifest, identity, folder.found_.entries, folder.found_.choices);
  }
  folder.store_->remove_temporaries();
  folder.manifest_ = std::make_unique<ManifestWriter>(fs, manifest);
  return folder;
}

ManifestContents read_bake(FileSystem& fs, const FileSystem::Path& dir) {
  ManifestContents contents = read_manifest(fs, dir / kManifestName);
  if (!contents.exists || (!contents.has_header && contents.entries.empty())) {
    throw UserError(dir.string() + ": is not the folder of a bake (no sound " + kManifestName +
                    "); give the folder that prt_bake wrote to");
  }
  if (contents.outdated) {
    throw UserError(dir.string() +
                    ": made by an older prtbake; bake again with this one, which replaces it");
  }
  return contents;
}

}  // namespace prt
