#include "base/hash.h"

#include <xxhash.h>

#include <cstddef>

#include "base/error.h"

namespace prt {

namespace {
Digest to_digest(XXH128_hash_t h) { return {h.high64, h.low64}; }
}  // namespace

std::string Digest::hex() const {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text(32, '0');
  for (int i = 0; i < 16; ++i) {
    text[15 - i] = kDigits[(high >> (4 * i)) & 15];
    text[31 - i] = kDigits[(low >> (4 * i)) & 15];
  }
  return text;
}

Digest Digest::from_hex(std::string_view text) {
  if (text.size() != 32) throw UnsoundData("not a 32-digit hash: '" + std::string(text) + "'");
  Digest digest;
  for (int i = 0; i < 32; ++i) {
    const char c = text[i];
    std::uint64_t value = 0;
    if (c >= '0' && c <= '9') {
      value = c - '0';
    } else if (c >= 'a' && c <= 'f') {
      value = c - 'a' + 10;
    } else {
      throw UnsoundData("not a 32-digit hash: '" + std::string(text) + "'");
    }
    auto& half = i < 16 ? digest.high : digest.low;
    half = (half << 4) | value;
  }
  return digest;
}

Digest hash_bytes(std::span<const std::byte> bytes) {
  return to_digest(XXH3_128bits(bytes.data(), bytes.size()));
}

Digest hash_text(std::string_view text) {
  return to_digest(XXH3_128bits(text.data(), text.size()));
}

struct Hasher::State {
  XXH3_state_t* xxh = XXH3_createState();
};

Hasher::Hasher() : state_(std::make_unique<State>()) { XXH3_128bits_reset(state_->xxh); }
Hasher::~Hasher() { XXH3_freeState(state_->xxh); }

Hasher& Hasher::add(std::span<const std::byte> bytes) {
  const std::uint64_t size = bytes.size();
  XXH3_128bits_update(state_->xxh, &size, sizeof size);
  XXH3_128bits_update(state_->xxh, bytes.data(), bytes.size());
  return *this;
}

Hasher& Hasher::add(std::string_view text) {
  return add(std::as_bytes(std::span(text.data(), text.size())));
}

Digest Hasher::digest() const { return to_digest(XXH3_128bits_digest(state_->xxh)); }

}  // namespace prt
