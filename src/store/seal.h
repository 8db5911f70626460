// The end of a file that proves all before it unchanged: 32 bytes that HDF5 tools skip, magic,
// length and XXH3-128 of everything before.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/hash.h"

namespace prt {

inline constexpr std::size_t kSealBytes = 32;

void append_seal(std::vector<std::byte>& file);

/// Content hash of a file: XXH3-128 of all bytes before the seal, which states it. Throws
/// UnsoundData if the seal is missing or broken.
Digest verify_seal(std::span<const std::byte> file);

/// The content hash that the seal states, unverified: for bytes that were sealed a moment ago.
/// Throws UnsoundData if there is no seal.
Digest sealed_content(std::span<const std::byte> file);

}  // namespace prt
