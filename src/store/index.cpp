#include "store/index.h"

#include <algorithm>
#include <map>
#include <vector>

#include "store/bake_folder.h"
#include "store/hdf5_memory.h"

namespace prt {

namespace {

std::string link_name(const IndexEntry& entry) {
  const std::string prefix = entry.kind + "/";
  std::string name = entry.task;
  if (name.starts_with(prefix)) name.erase(0, prefix.size());
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

/// A path that leads to the root like any other but is spelt as only the n-th link spells it:
/// h5ls 1.10 tells external links apart by the path in the other file alone, not by that file's
/// name, and follows just the first of those that are alike. HDF5 skips "." and empty steps.
std::string spelling_of_root(std::size_t n) {
  std::string path = "/";
  for (; n > 0; n >>= 1) path += (n & 1) != 0 ? "./" : "/";
  return path;
}

}  // namespace

std::string index_path(const IndexEntry& entry) {
  return "/" + entry.kind + "/" + link_name(entry);
}

void write_index(FileSystem& fs, const FileSystem::Path& bake_dir,
                 std::span<const IndexEntry> entries) {
  std::map<std::string, std::map<std::string, std::string>> file_of_link_of_stage;
  for (const IndexEntry& entry : entries) {
    file_of_link_of_stage[entry.kind][link_name(entry)] =
        "artifacts/" + entry.kind + "/" + entry.key.hex() + ".h5";
  }
  std::vector<std::byte> bytes;
  {
    const hdf5::Session session;
    hdf5::MemoryFile file(1 << 20);
    std::size_t links = 0;
    for (const auto& [stage, file_of_link] : file_of_link_of_stage) {
      const hdf5::Handle group = hdf5::require_group(file.id(), stage);
      for (const auto& [link, target] : file_of_link) {
        hdf5::check(H5Lcreate_external(target.c_str(), spelling_of_root(links++).c_str(),
                                       group.id(), link.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                    "linking an artifact");
      }
    }
    bytes = file.close();
  }
  replace_file(fs, bake_dir / kIndexName, bytes);
}

}  // namespace prt
