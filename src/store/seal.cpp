#include "store/seal.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "base/error.h"

namespace prt {

namespace {

constexpr std::array<char, 8> kMagic = {'P', 'R', 'T', 's', 'e', 'a', 'l', '1'};

struct Seal {
  std::array<char, 8> magic;
  std::uint64_t length;
  std::uint64_t high;
  std::uint64_t low;
};
static_assert(sizeof(Seal) == kSealBytes);

}  // namespace

void append_seal(std::vector<std::byte>& file) {
  const Digest digest = hash_bytes(file);
  const Seal seal{kMagic, file.size(), digest.high, digest.low};
  const auto raw = std::as_bytes(std::span(&seal, 1));
  file.insert(file.end(), raw.begin(), raw.end());
}

Digest verify_seal(std::span<const std::byte> file) {
  const Digest stated = sealed_content(file);
  if (hash_bytes(file.first(file.size() - sizeof(Seal))) != stated) {
    throw UnsoundData("corrupt: its checksum differs");
  }
  return stated;
}

Digest sealed_content(std::span<const std::byte> file) {
  Seal seal{};
  if (file.size() < sizeof seal) throw UnsoundData("too short to be a file of ours");
  const std::size_t length = file.size() - sizeof seal;
  std::memcpy(&seal, file.data() + length, sizeof seal);
  if (seal.magic != kMagic) throw UnsoundData("not a file of ours, or a truncated one");
  if (seal.length != length) throw UnsoundData("truncated");
  return {seal.high, seal.low};
}

}  // namespace prt
