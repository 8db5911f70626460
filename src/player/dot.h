// Dot products of contiguous numbers, the work of playing. Integers stay integers until they are
// multiplied: what is read is a quarter of the floats'. Internal to player/.
#pragma once

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "operators/quantised.h"

namespace prt {

inline constexpr std::size_t kLanes = 8;  // floats of an AVX2 register

using EightFloats = float __attribute__((vector_size(kLanes * sizeof(float))));

/// Eight numbers from anywhere, as floats.
inline EightFloats load(const float* from) {
  EightFloats numbers;
  std::memcpy(&numbers, from, sizeof numbers);
  return numbers;
}
#ifdef __AVX2__
// Left to the compiler these become eight conversions of one number each.
inline EightFloats load(const std::int16_t* from) {
  const __m128i numbers = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(numbers));
}
inline EightFloats load(const std::uint16_t* from) {
  const __m128i numbers = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  return _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(numbers));
}
inline EightFloats load(const std::int8_t* from) {
  const __m128i numbers = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  return _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(numbers));
}
#else
template <typename Number>
EightFloats load(const Number* from) {
  EightFloats numbers{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) numbers[lane] = static_cast<float>(from[lane]);
  return numbers;
}
#endif

/// Four numbers from one place and four from another.
inline EightFloats load_two(const float* low, const float* high) {
#ifdef __AVX2__
  return _mm256_set_m128(_mm_loadu_ps(high), _mm_loadu_ps(low));
#else
  return EightFloats{low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]};
#endif
}

/// Sum over the lanes, in a fixed order.
inline float sum_of(const EightFloats& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

/// a · b; any count, fastest for whole vectors.
template <typename Number>
float dot(const Number* a, const float* b, std::size_t count) {
  EightFloats even{};
  EightFloats odd{};
  std::size_t i = 0;
  for (; i + 2 * kLanes <= count; i += 2 * kLanes) {  // two chains: an addition takes its time
    even += load(a + i) * load(b + i);
    odd += load(a + i + kLanes) * load(b + i + kLanes);
  }
  if (i + kLanes <= count) {
    even += load(a + i) * load(b + i);
    i += kLanes;
  }
  float rest = 0.0F;
  for (; i < count; ++i) rest += static_cast<float>(a[i]) * b[i];
  return sum_of(even + odd) + rest;
}

/// Sums over the lanes of four, in a fixed order.
inline std::array<float, 4> sums_of(const std::array<EightFloats, 4>& v) {
  std::array<float, 4> sums{};
#ifdef __AVX2__
  const __m256 halves = _mm256_hadd_ps(_mm256_hadd_ps(v[0], v[1]), _mm256_hadd_ps(v[2], v[3]));
  _mm_storeu_ps(sums.data(),
                _mm_add_ps(_mm256_castps256_ps128(halves), _mm256_extractf128_ps(halves, 1)));
#else
  for (std::size_t k = 0; k < 4; ++k) sums[k] = sum_of(v[k]);
#endif
  return sums;
}

/// Products of four rows with b, which is read once. `count` is whole vectors.
template <typename Number>
std::array<float, 4> dot_of_rows(const std::array<const Number*, 4>& rows, const float* b,
                                 std::size_t count) {
  std::array<EightFloats, 4> sums{};
  for (std::size_t i = 0; i < count; i += kLanes) {
    const EightFloats values = load(b + i);
    for (std::size_t k = 0; k < 4; ++k) sums[k] += load(rows[k] + i) * values;
  }
  return sums_of(sums);
}

/// a · b for three b, `stride` floats apart: a is read once.
template <typename Number>
std::array<float, 3> dot_of_three(const Number* a, const float* b, std::size_t stride,
                                  std::size_t count) {
  std::array<EightFloats, 3> sums{};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const EightFloats values = load(a + i);
    for (std::size_t c = 0; c < 3; ++c) sums[c] += values * load(b + c * stride + i);
  }
  std::array<float, 3> result{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = i; k < count; ++k) {
      result[c] += static_cast<float>(a[k]) * b[c * stride + k];
    }
    result[c] += sum_of(sums[c]);
  }
  return result;
}

/// use(pointer to the matrix's numbers), which are integers of its size or floats.
template <typename Use>
auto with_numbers(const QuantisedMatrix& m, Use&& use) {
  if (m.bits == 8) return use(m.int8.data());
  if (m.bits == 16) return use(m.int16.data());
  return use(m.float32.data());
}

}  // namespace prt
