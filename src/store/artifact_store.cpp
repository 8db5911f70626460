#include "store/artifact_store.h"

#include <cerrno>
#include <stdexcept>
#include <utility>

#include "base/log.h"
#include "store/seal.h"

namespace prt {

namespace {

void check_label(const ArtifactLabel& label, const std::string& stage, const Digest& key) {
  if (label.kind != stage || label.key != key) {
    throw UnsoundData("holds another artifact: " + label.kind + "/" + label.key.hex());
  }
}

bool is_temporary(const std::string& name) { return name.ends_with(kTemporarySuffix); }
bool is_ours(const std::string& name) { return is_temporary(name) || name.ends_with(".h5"); }

}  // namespace

ArtifactStore::ArtifactStore(FileSystem& fs, FileSystem::Path bake_dir)
    : fs_(fs), bake_dir_(std::move(bake_dir)) {}

FileSystem::Path ArtifactStore::path(const std::string& stage, const Digest& key) const {
  if (stage.empty() || stage.front() == '.' || stage.find('/') != std::string::npos) {
    throw std::logic_error("'" + stage + "' cannot be the name of a stage");
  }
  return root() / stage / (key.hex() + ".h5");
}

Digest ArtifactStore::write(const std::string& stage, const Digest& key, const Artifact& artifact,
                            const Origin& origin) {
  const auto file = path(stage, key);
  const auto bytes = to_hdf5(artifact, {stage, key, origin.code_version, origin.equation});
  const Digest content = sealed_content(bytes);
  if (const auto existing = fs_.size(file) ? check(stage, key) : std::nullopt) {
    if (*existing == content) return content;
    throw DeterminismError(file.string() + ": two different results for one key; content " +
                           existing->hex() + " is stored, " + content.hex() + " came now");
  }
  make_stage(stage);
  replace_file(fs_, file, bytes);
  return content;
}

std::optional<Digest> ArtifactStore::check(const std::string& stage, const Digest& key) {
  const auto file = path(stage, key);
  if (!fs_.size(file)) return std::nullopt;
  try {
    return head(stage, key).content;
  } catch (const UnsoundData& error) {
    log::warn("{}; it will be made again", error.what());
  }
  fs_.remove(file);
  return std::nullopt;
}

LabelledArtifact ArtifactStore::head(const std::string& stage, const Digest& key) const {
  return load(stage, key, head_from_hdf5);
}

std::shared_ptr<const Artifact> ArtifactStore::read(const std::string& stage, const Digest& key,
                                                    const Digest& expected) const {
  LabelledArtifact file = load(stage, key, from_hdf5);
  if (file.content != expected) {
    throw UnsoundData(path(stage, key).string() + ": content " + file.content.hex() + " where " +
                      expected.hex() + " was expected");
  }
  return std::make_shared<const Artifact>(std::move(file.artifact));
}

std::uint64_t ArtifactStore::bytes(const std::string& stage, const Digest& key) const {
  return fs_.size(path(stage, key)).value_or(0);
}

bool ArtifactStore::remove(const std::string& stage, const Digest& key) {
  return fs_.remove(path(stage, key));
}

void ArtifactStore::remove_temporaries() { remove_matching(is_temporary); }

void ArtifactStore::remove_all() { remove_matching(is_ours); }

LabelledArtifact ArtifactStore::load(const std::string& stage, const Digest& key,
                                     Parse parse) const {
  const auto file = path(stage, key);
  try {
    LabelledArtifact result = parse(fs_.read(file));
    check_label(result.label, stage, key);
    return result;
  } catch (const UnsoundData& error) {
    throw UnsoundData(file.string() + ": " + error.what());
  } catch (const FileError& error) {
    // What cannot be read is as good as damaged: it is made again. A lack of permission is the
    // user's to mend.
    if (error.error_number() == EACCES || error.error_number() == EPERM) throw;
    throw UnsoundData(error.what());
  }
}

void ArtifactStore::make_stage(const std::string& stage) {
  const std::lock_guard lock(mutex_);
  if (made_stages_.contains(stage)) return;
  fs_.make_dirs(root() / stage);
  made_stages_.insert(stage);
}

void ArtifactStore::remove_matching(bool (*matches)(const std::string& name)) {
  for (const std::string& stage : fs_.list(root())) {
    for (const std::string& name : fs_.list(root() / stage)) {
      if (matches(name)) fs_.remove(root() / stage / name);
    }
  }
}

}  // namespace prt
