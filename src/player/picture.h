// Pictures of a played package, on the CPU.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "player/evaluator.h"
#include "player/rasteriser.h"
#include "scene/environment.h"

namespace prt {

/// What a picture shows; parts have the exposure of the whole, so that they can be compared.
enum class Show {
  kFull,
  kDirect,
  kIndirect,
  kVisibility,  ///< share of the first light that arrives; dark red where it shines from behind
  kClusters     ///< cluster of the nearest sample, one colour each
};

struct PictureSettings {
  int width = 1024;
  int height = 768;
  Show show = Show::kFull;
  int samples_per_side = 1;                      ///< of a pixel: its square is averaged
  std::optional<float> exposure = std::nullopt;  ///< factor on radiance; none: the picture's own
  /// Behind all surfaces, and mirrored in them if reflection > 0; null: plain. Not in pictures of
  /// visibility and clusters.
  const Environment* environment = nullptr;
  float reflection = 0.0F;  ///< share of the mirrored environment that is added (SH §7)
  bool linear = false;      ///< radiance as it is, for kFull, kDirect and kIndirect only
  unsigned threads = 0;
};

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< sRGB, top row first; empty for a linear picture
  /// Of a linear picture, W/(m² sr), RGB, top row first, neither exposed nor toned; where there is
  /// no surface the environment's, or 0.
  std::vector<float> radiance;
  float exposure = 1.0F;
  std::size_t covered = 0;     ///< picture samples that see a surface
  std::size_t unreached = 0;   ///< of them: no splat reaches the point; drawn black
  std::size_t holes = 0;       ///< of those: on a side of a triangle that has samples
  std::size_t not_finite = 0;  ///< with a value that is not finite; drawn black
};

/// Radiance of a Lambert surface, albedo/π · (direct + indirect), negative values clamped here and
/// nowhere before, and what it mirrors of the environment; times exposure; through the filmic curve
/// of Narkowicz (2015); as sRGB. The picture's own exposure puts the 90th percentile of its
/// luminance at 0.6 before the curve.
Picture render(const Evaluator& evaluator, const SampleIrradiance& irradiance,
               const SceneCamera& camera, const PictureSettings& settings);

}  // namespace prt
