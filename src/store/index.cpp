#include "store/index.h"

#include <algorithm>
#include <map>
#include <vector>

#include "store/bake_folder.h"
#include "store/hdf5_attributes.h"
#include "store/hdf5_memory.h"
#include "store/seal.h"

namespace prt {

namespace {

std::string link_name(const IndexEntry& entry) {
  const std::string prefix = entry.kind + "/";
  std::string name = entry.task;
  if (name.starts_with(prefix)) name.erase(0, prefix.size());
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

herr_t collect_key(hid_t group, const char* link, const H5L_info_t* info, void* out) {
  if (info->type != H5L_TYPE_EXTERNAL) return 0;
  std::vector<char> value(info->u.val_size);
  const char* file = nullptr;
  const char* path = nullptr;
  if (H5Lget_val(group, link, value.data(), value.size(), H5P_DEFAULT) < 0 ||
      H5Lunpack_elink_val(value.data(), value.size(), nullptr, &file, &path) < 0) {
    return -1;
  }
  static_cast<std::vector<std::string>*>(out)->emplace_back(path);
  return 0;
}

}  // namespace

std::string index_path(const IndexEntry& entry) {
  return "/" + entry.kind + "/" + link_name(entry);
}

void write_index(FileSystem& fs, const FileSystem::Path& bake_dir,
                 std::span<const IndexEntry> entries, const nlohmann::json& attributes) {
  std::map<std::string, std::map<std::string, std::string>> key_of_link_of_stage;
  for (const IndexEntry& entry : entries) {
    key_of_link_of_stage[entry.kind][link_name(entry)] = entry.key.hex();
  }
  std::vector<std::byte> bytes;
  {
    const hdf5::Session session;
    hdf5::MemoryFile file(1 << 20);
    for (const auto& [name, value] : attributes.items()) {
      hdf5::write_attribute(file.id(), name, value);
    }
    for (const auto& [stage, key_of_link] : key_of_link_of_stage) {
      const hdf5::Handle group = hdf5::require_group(file.id(), stage);
      for (const auto& [link, key] : key_of_link) {
        const std::string target = "artifacts/" + stage + "/" + key + ".h5";
        hdf5::check(H5Lcreate_external(target.c_str(), ("/" + key).c_str(), group.id(),
                                       link.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                    "linking an artifact");
      }
    }
    bytes = file.close();
  }
  append_seal(bytes);
  replace_file(fs, bake_dir / kIndexName, bytes);
}

std::set<Digest> read_index(FileSystem& fs, const FileSystem::Path& bake_dir) {
  const auto bytes = fs.read(bake_dir / kIndexName);
  verify_seal(bytes);
  std::vector<std::string> paths;  // "/KEY"
  {
    const hdf5::Session session;
    const hdf5::BorrowedFile file(
        std::span<const std::byte>(bytes).first(bytes.size() - kSealBytes));
    hdf5::check(H5Lvisit(file.id(), H5_INDEX_NAME, H5_ITER_INC, collect_key, &paths),
                "reading the index");
  }
  std::set<Digest> keys;
  for (const std::string& path : paths) keys.insert(Digest::from_hex(path.substr(1)));
  return keys;
}

}  // namespace prt
