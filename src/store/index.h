// bake.h5: one file through which HDF5 tools see every dataset of a bake.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>

#include "base/hash.h"
#include "store/file_system.h"

namespace prt {

/// One artifact to link to.
struct IndexEntry {
  std::string task;  ///< task id: "rays/0007"
  std::string kind;  ///< stage: "rays"
  Digest key;
};

/// Path of a task's link in the index: /STAGE/NAME, NAME the task id without a leading "STAGE/" and
/// with '.' for every other '/': always two levels. "rays/0007" of stage rays is /rays/0007,
/// "samples" of stage samples is /samples/samples.
std::string index_path(const IndexEntry& entry);

/// Writes bake_dir/bake.h5 with an external link to each artifact, relative to the folder, so that
/// the folder can be moved; sealed as artifacts are. Equal entries in any order give equal bytes.
/// `attributes` (a JSON object) become those of the file's root.
void write_index(FileSystem& fs, const FileSystem::Path& bake_dir,
                 std::span<const IndexEntry> entries,
                 const nlohmann::json& attributes = nlohmann::json::object());

/// KEYs that bake_dir/bake.h5 links to. Throws UnsoundData if it is damaged, FileError if missing.
std::set<Digest> read_index(FileSystem& fs, const FileSystem::Path& bake_dir);

}  // namespace prt
