#include "store/hdf5_image.h"

#include <algorithm>
#include <stdexcept>

#include "base/error.h"
#include "store/hdf5_attributes.h"
#include "store/hdf5_handle.h"
#include "store/hdf5_memory.h"
#include "store/seal.h"

namespace prt {

namespace {

using hdf5::check;
using hdf5::Handle;

constexpr std::size_t kChunkBytes = 1 << 20;
/// The same in file and memory: artifacts are little-endian, as every machine we run on.
hid_t hdf5_type(ElementType type) {
  switch (type) {
    case ElementType::kInt8:
      return H5T_STD_I8LE;
    case ElementType::kInt16:
      return H5T_STD_I16LE;
    case ElementType::kUint8:
      return H5T_STD_U8LE;
    case ElementType::kUint16:
      return H5T_STD_U16LE;
    case ElementType::kUint32:
      return H5T_STD_U32LE;
    case ElementType::kUint64:
      return H5T_STD_U64LE;
    case ElementType::kFloat32:
      return H5T_IEEE_F32LE;
    case ElementType::kFloat64:
      return H5T_IEEE_F64LE;
  }
  throw std::logic_error("unknown element type");
}

ElementType element_type_from(hid_t type) {
  for (const ElementType candidate :
       {ElementType::kInt8, ElementType::kInt16, ElementType::kUint8, ElementType::kUint16,
        ElementType::kUint32, ElementType::kUint64, ElementType::kFloat32, ElementType::kFloat64}) {
    if (H5Tequal(type, hdf5_type(candidate)) > 0) return candidate;
  }
  throw UnsoundData("a dataset has an element type that artifacts do not have");
}

/// Cuts the slowest axes until a chunk has about kChunkBytes, into pieces as even as can be: the
/// last chunk is stored whole however little of it is used.
std::vector<hsize_t> chunk_shape(const Dataset& dataset) {
  std::vector<hsize_t> chunk(dataset.dims.begin(), dataset.dims.end());
  std::size_t bytes = dataset.bytes.size();
  for (auto& side : chunk) {
    if (bytes <= kChunkBytes) break;
    const hsize_t full = side;
    const hsize_t pieces = std::min<hsize_t>(full, (bytes + kChunkBytes - 1) / kChunkBytes);
    side = (full + pieces - 1) / pieces;
    bytes = bytes / full * side;
  }
  return chunk;
}

void check_shape(const std::string& name, const Dataset& dataset) {
  std::uint64_t count = 1;
  for (const auto side : dataset.dims) count *= side;
  if (count * element_size(dataset.type) != dataset.bytes.size() ||
      dataset.dims.size() > H5S_MAX_RANK) {
    throw std::logic_error("artifact array " + name + ": shape and size differ");
  }
}

Handle data_space(const Dataset& dataset) {
  if (dataset.dims.empty()) return {H5Screate(H5S_SCALAR), H5Sclose, "making a scalar"};
  const std::vector<hsize_t> dims(dataset.dims.begin(), dataset.dims.end());
  return {H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose,
          "making a shape"};
}

Handle dataset_properties(const Dataset& dataset) {
  Handle properties = hdf5::creation_properties(H5P_DATASET_CREATE);
  if (!dataset.dims.empty() && !dataset.bytes.empty()) {
    const auto chunk = chunk_shape(dataset);
    check(H5Pset_chunk(properties.id(), static_cast<int>(chunk.size()), chunk.data()),
          "setting chunks");
    check(H5Pset_fletcher32(properties.id()), "setting checksums");
    // Zeros, not whatever memory held, in the unused part of the last chunk.
    check(H5Pset_fill_time(properties.id(), H5D_FILL_TIME_ALLOC), "setting the fill time");
  }
  return properties;
}

/// Opens the groups that a name with '/' asks for and returns the innermost and the last part.
std::pair<Handle, std::string> enter_groups(hid_t top, const std::string& name) {
  Handle group(H5Gopen2(top, ".", H5P_DEFAULT), H5Gclose, "opening a group");
  std::size_t begin = 0;
  while (true) {
    const std::size_t slash = name.find('/', begin);
    std::string part = name.substr(begin, slash - begin);
    if (part.empty() || part == "." || part.find('\0') != std::string::npos) {
      throw std::logic_error("artifact array '" + name + "' has a name that cannot be stored");
    }
    if (slash == std::string::npos) return {std::move(group), std::move(part)};
    group = hdf5::require_group(group.id(), part);
    begin = slash + 1;
  }
}

void write_dataset(hid_t top, const std::string& name, const Dataset& dataset) {
  check_shape(name, dataset);
  const auto [group, leaf] = enter_groups(top, name);
  const Handle space = data_space(dataset);
  const Handle properties = dataset_properties(dataset);
  const hid_t type = hdf5_type(dataset.type);
  const Handle stored(H5Dcreate2(group.id(), leaf.c_str(), type, space.id(), H5P_DEFAULT,
                                 properties.id(), H5P_DEFAULT),
                      H5Dclose, "making a dataset");
  if (!dataset.bytes.empty()) {
    check(H5Dwrite(stored.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, dataset.bytes.data()),
          "writing a dataset");
  }
  hdf5::write_attribute(stored.id(), "units", dataset.units);
  hdf5::write_attribute(stored.id(), "meaning", dataset.meaning);
}

Dataset read_dataset(hid_t group, const char* name, std::size_t file_bytes) {
  const Handle stored(H5Dopen2(group, name, H5P_DEFAULT), H5Dclose, "opening a dataset");
  const Handle type(H5Dget_type(stored.id()), H5Tclose, "reading a type");
  const Handle space(H5Dget_space(stored.id()), H5Sclose, "reading a shape");
  Dataset dataset;
  dataset.type = element_type_from(type.id());
  std::vector<hsize_t> dims(
      static_cast<std::size_t>(check(H5Sget_simple_extent_ndims(space.id()), "reading a rank")));
  check(H5Sget_simple_extent_dims(space.id(), dims.data(), nullptr), "reading a shape");
  dataset.dims.assign(dims.begin(), dims.end());
  // Nothing is compressed, so no dataset is larger than its file.
  std::size_t bytes = element_size(dataset.type);
  for (const hsize_t side : dims) {
    if (side != 0 && bytes > file_bytes / side) throw UnsoundData("a dataset is beyond its file");
    bytes *= side;
  }
  dataset.bytes.resize(bytes);
  if (bytes > 0) {
    check(H5Dread(stored.id(), hdf5_type(dataset.type), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                  dataset.bytes.data()),
          "reading a dataset");
  }
  dataset.units = hdf5::read_attribute(stored.id(), "units").get<std::string>();
  dataset.meaning = hdf5::read_attribute(stored.id(), "meaning").get<std::string>();
  return dataset;
}

herr_t collect_link(hid_t, const char* name, const H5L_info_t* info, void* out) {
  if (info->type != H5L_TYPE_HARD) return -1;
  static_cast<std::vector<std::string>*>(out)->emplace_back(name);
  return 0;
}

void read_group(hid_t group, const std::string& prefix, std::size_t file_bytes, Artifact& out) {
  std::vector<std::string> names;
  check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_link, &names),
        "listing a group");
  for (const std::string& name : names) {
    H5O_info_t info;
    check(H5Oget_info_by_name(group, name.c_str(), &info, H5P_DEFAULT), "looking at an object");
    if (info.type == H5O_TYPE_DATASET) {
      out.datasets[prefix + name] = read_dataset(group, name.c_str(), file_bytes);
    } else if (info.type == H5O_TYPE_GROUP) {
      const Handle inner(H5Gopen2(group, name.c_str(), H5P_DEFAULT), H5Gclose, "opening a group");
      read_group(inner.id(), prefix + name + "/", file_bytes, out);
    } else {
      throw UnsoundData("an artifact holds neither datasets nor groups");
    }
  }
}

ArtifactLabel read_label(hid_t root) {
  const auto schema = hdf5::read_attribute(root, "schema_version").get<std::int64_t>();
  if (schema != kArtifactSchemaVersion) {
    throw UnsoundData("artifact of schema version " + std::to_string(schema) + ", not " +
                      std::to_string(kArtifactSchemaVersion));
  }
  ArtifactLabel label;
  label.kind = hdf5::read_attribute(root, "kind").get<std::string>();
  label.key = Digest::from_hex(hdf5::read_attribute(root, "key").get<std::string>());
  label.code_version = hdf5::read_attribute(root, "code_version").get<int>();
  label.equation = hdf5::read_attribute(root, "equation").get<std::string>();
  return label;
}

void write_label(hid_t file, const ArtifactLabel& label) {
  const Handle root(H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose, "opening the root");
  hdf5::write_attribute(root.id(), "schema_version", kArtifactSchemaVersion);
  hdf5::write_attribute(root.id(), "code_version", label.code_version);
  hdf5::write_attribute(root.id(), "kind", label.kind);
  hdf5::write_attribute(root.id(), "key", label.key.hex());
  hdf5::write_attribute(root.id(), "equation", label.equation);
}

void write_artifact(hid_t group, const Artifact& artifact) {
  for (const auto& [name, value] : artifact.attributes.items()) {
    hdf5::write_attribute(group, name, value);
  }
  for (const auto& [name, dataset] : artifact.datasets) write_dataset(group, name, dataset);
}

/// JSON type errors mean an attribute of another type than ours.
LabelledArtifact read_sealed(std::span<const std::byte> file, bool with_datasets) {
  LabelledArtifact result;
  result.content = verify_seal(file);
  const hdf5::Session session;
  try {
    const hdf5::BorrowedFile opened(file.first(file.size() - kSealBytes));
    const Handle root(H5Gopen2(opened.id(), "/", H5P_DEFAULT), H5Gclose, "opening the root");
    result.label = read_label(root.id());
    const Handle group(H5Gopen2(root.id(), result.label.key.hex().c_str(), H5P_DEFAULT), H5Gclose,
                       "opening the artifact's group");
    result.artifact.attributes = hdf5::read_attributes(group.id());
    if (with_datasets) read_group(group.id(), "", file.size(), result.artifact);
  } catch (const nlohmann::json::exception& error) {
    throw UnsoundData(std::string("an attribute cannot be read: ") + error.what());
  }
  return result;
}

std::size_t expected_bytes(const Artifact& artifact) {
  std::size_t bytes = 1 << 16;
  for (const auto& [name, dataset] : artifact.datasets) {
    // The last chunk is stored whole: at most one row per chunk more.
    bytes += dataset.bytes.size() + dataset.bytes.size() / 64 + 8192;
  }
  return bytes;
}

}  // namespace

std::vector<std::byte> to_hdf5(const Artifact& artifact, const ArtifactLabel& label) {
  std::vector<std::byte> bytes;
  {
    const hdf5::Session session;
    hdf5::MemoryFile file(expected_bytes(artifact));
    write_label(file.id(), label);
    write_artifact(hdf5::require_group(file.id(), label.key.hex()).id(), artifact);
    bytes = file.close();
  }
  append_seal(bytes);
  return bytes;
}

LabelledArtifact from_hdf5(std::span<const std::byte> file) { return read_sealed(file, true); }

LabelledArtifact head_from_hdf5(std::span<const std::byte> file) {
  return read_sealed(file, false);
}

}  // namespace prt
