// Names and numbers of the root extension, shared by writer and reader. Described in FORMAT.md.
// Internal to package/.
#pragma once

#include <cstddef>
#include <cstdint>

namespace prt {

inline constexpr const char* kExtension = "PRT_light_transfer";
/// Raised whenever an older reader would misunderstand the file.
inline constexpr std::uint64_t kFormatVersion = 3;
/// What has no environment, and what has no walls either, is written as the version that knows
/// none: older readers read it, too.
inline constexpr std::uint64_t kVersionWithoutEnvironment = 2;
inline constexpr std::uint64_t kVersionWithoutWalls = 1;

/// Scene::origin, left out where it is zero.
inline constexpr const char* kOrigin = "origin";
inline constexpr const char* kSampleIrradiance = "sample_irradiance";
inline constexpr const char* kClusterCoefficients = "cluster_coefficients";
inline constexpr const char* kEnvironmentCoefficients = "environment_coefficients";
inline constexpr const char* kClusterProjection = "cluster_projection";
inline constexpr const char* kClusterTransfer = "cluster_transfer";
inline constexpr const char* kNearTransfer = "near_transfer";

/// Up to so many things are numbered in 16 bits.
inline constexpr std::size_t kShortIndices = 65536;
/// Unit vectors are stored as normalised SHORT.
inline constexpr float kUnitScale = 32767.0F;

}  // namespace prt
