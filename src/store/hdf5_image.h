// An artifact as the bytes of an HDF5 file, and back. HDF5 only serialises: it works on memory, and
// all disk access goes through store/file_system.h.
//
// Layout: an HDF5 file in the 1.8 format without any object times, then a seal (store/seal.h). A
// file proves itself sound by its seal before HDF5 parses a byte of it. Each dataset is cut into
// chunks of about 1 MiB with fletcher32 checksums, so that other HDF5 programs notice damage, too;
// arrays without a value and scalars have no chunks.
//
// Root attributes: schema_version, code_version, kind, key, equation. All datasets are in one group
// named by the KEY: h5ls 1.10 tells external links apart by the path in the other file alone, and
// follows each path once. The group's attributes are the artifact's: integers (unsigned unless
// negative), doubles, booleans (an enumeration, as h5py has it) and strings typed as such, nested
// values as JSON text under "json:NAME". Each dataset has attributes `units` and `meaning`.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/hash.h"
#include "store/artifact.h"

namespace prt {

/// Version of this layout; readers refuse others. Raise kManifestSchemaVersion with it: contents
/// change, and a manifest's contents are those of its time.
inline constexpr int kArtifactSchemaVersion = 3;

/// What an artifact is and which code made it.
struct ArtifactLabel {
  std::string kind;      ///< kind of the task, also the stage
  Digest key;            ///< KEY of design §4
  int code_version = 1;  ///< TaskSpec::version
  std::string equation;  ///< of the paper, e.g. "Leonhardt & Bohn, eq. 8"
  friend bool operator==(const ArtifactLabel&, const ArtifactLabel&) = default;
};

struct LabelledArtifact {
  ArtifactLabel label;
  Digest content;  ///< as verify_seal
  Artifact artifact;
};

/// Bytes of the file, seal included. Equal arguments give equal bytes in every process. Throws
/// std::logic_error for what cannot be stored: a dataset whose shape and bytes differ, empty or
/// odd names.
std::vector<std::byte> to_hdf5(const Artifact& artifact, const ArtifactLabel& label);

/// Inverse of to_hdf5; element types, shapes and attributes come back exactly. Throws UnsoundData
/// if the seal is broken, the schema is another one or anything does not parse.
LabelledArtifact from_hdf5(std::span<const std::byte> file);

/// The same without the datasets, which are not read.
LabelledArtifact head_from_hdf5(std::span<const std::byte> file);

}  // namespace prt
