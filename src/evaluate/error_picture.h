// Where a package is wrong under one light, as a picture.
#pragma once

#include "evaluate/reference.h"
#include "player/evaluator.h"
#include "player/picture.h"

namespace prt {

struct ErrorPictureSettings {
  int width = 320;  ///< of each panel, pixels
  int height = 240;
  int paths = 64;            ///< per pixel
  std::uint64_t stream = 0;  ///< random stream
};

/// An error of this share of the mean irradiance has the strongest colour.
inline constexpr float kStrongestError = 0.5F;

/// Two panels side by side, direct light left and indirect light right: what the player shows minus
/// what the path tracer says at each pixel, over the mean of what it says in the panel. Red is too
/// bright, blue too dark, white right, dark grey where no splat reaches, yellow where a value is
/// not finite; a strip below shows the scale from −kStrongestError to +kStrongestError. Indirect
/// errors are means over a few pixels of the same surface, and some of the reference's noise is
/// left in them.
Picture draw_error(const Evaluator& player, const ReferenceInputs& inputs, const Light& light,
                   const SceneCamera& camera, const ErrorPictureSettings& settings);

}  // namespace prt
