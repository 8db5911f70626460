// Based on: M. Leonhardt, C.-A. Bohn, "Precomputed Illumination for Virtual Reality Scenarios"
// (LB).
//
// Clustered PCA: a visibility basis per cluster from hemispherical depth buffers (§4.2), a basis
// for direct light per cluster from example lights (§4.3.1), and transfer from every sender
// cluster's basis to every receiver's samples (§4.3.2), compressed (§4.4).
//
// Where we leave the paper, and why:
// - Eq. 10 subtracts the mean direct light; its own transfer is then lost. Our light basis is
//   uncentred, so the map stays linear in the light.
// - Light functions are chosen by the indirect light that they cause, and clusters share them out:
//   d2 of them in the mean, more where more hangs on them.
// - Light between samples that fill much of each other's hemisphere (lb.near_share) goes entry by
//   entry, three times to and fro, and the light functions serve the rest: what a near wall sends
//   back changes within a few samples, and owned most of the error.
// - A cluster that sees everything up to the walls of a convex space has no visibility basis: walls
//   say the same exactly. Elsewhere the basis has no functions whose energy rounding would drown.
// - Inner products are weighted by cell area: samples are only nearly uniform, and the transport
//   operator is symmetric in that product alone.
// - Basis functions are scaled by the typical size of their coefficients, so that truncation and
//   rounding weigh errors by what lights really do.
// - Besides photons (§4.3.2) the stored hemispherical hits are used as a one-bounce operator, and
//   further bounces come from a Galerkin system on snapshots: less noise in less time.
// - Transfer blocks are kept as low rank per receiver cluster instead of sparse rows (§4.4):
// smaller
//   at the same error.
#pragma once

#include "methods/method.h"

namespace prt {

const Method& lb_method();

}  // namespace prt
