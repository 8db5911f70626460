// Based on: R. Slomp, M. Oliveira, D. Patrício, "A Gentle Introduction to Precomputed Radiance
// Transfer" (SH), after P.-P. Sloan, J. Kautz, J. Snyder (2002).
//
// Light from infinitely far away as spherical harmonics, and its transfer to irradiance at each
// sample: in the open (§6.2.6.1), shadowed (§6.2.6.2), and bounced between surfaces (§6.2.6.3).
//
// Where we leave the tutorial, and why:
// - Transfer is of irradiance, not of reflected radiance: albedo is left to whoever shades, so that
//   textures stay sharp. Bounced light carries the albedos on its way.
// - No ray of its own: what the hemispherical rays of every sample met says where the sky is seen
//   and where light bounces from. A ray's visibility is taken against the closed form of an open
//   hemisphere, which then has no quadrature error, and little is left of it in half-open ones.
// - Transfer is kept as low rank per cluster, as Sloan, Hall, Hart & Snyder (2003) do, and as
//   integers.
#pragma once

#include "methods/method.h"

namespace prt {

const Method& sh_method();

}  // namespace prt
