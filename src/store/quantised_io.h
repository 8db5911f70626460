// Quantised matrices in artifacts.
#pragma once

#include <string>

#include "operators/quantised.h"
#include "store/artifact.h"

namespace prt {

/// Puts `name` (int8, int16 or float32, rows × cols) and `name`.scale (float32, rows).
void put_quantised(Artifact& artifact, const std::string& name, const QuantisedMatrix& matrix,
                   const std::string& units, const std::string& meaning);

/// Inverse of put_quantised. Throws UnsoundData if an array is missing or of a shape or type that
/// it does not make.
QuantisedMatrix get_quantised(const Artifact& artifact, const std::string& name);

}  // namespace prt
