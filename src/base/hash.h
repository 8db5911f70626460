// Content hashes (XXH3, 128 bits): names of artifacts and proofs that bytes are unchanged.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace prt {

struct Digest {
  std::uint64_t high = 0;
  std::uint64_t low = 0;
  friend auto operator<=>(const Digest&, const Digest&) = default;

  /// 32 lower-case hexadecimal digits.
  [[nodiscard]] std::string hex() const;
  /// Inverse of hex(); throws UnsoundData unless the text is exactly 32 hexadecimal digits.
  static Digest from_hex(std::string_view text);
};

/// Hash of one piece of memory.
Digest hash_bytes(std::span<const std::byte> bytes);
Digest hash_text(std::string_view text);

/// Hash of several pieces in order. Every piece is preceded by its length, so that ("ab","c") and
/// ("a","bc") differ.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;

  Hasher& add(std::span<const std::byte> bytes);
  Hasher& add(std::string_view text);
  template <typename T>
  requires std::is_trivially_copyable_v<T> Hasher& add_values(std::span<const T> values) {
    return add(std::as_bytes(values));
  }
  [[nodiscard]] Digest digest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace prt
