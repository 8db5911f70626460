// Lists of quantised matrices in few accessors: all 8-bit integers in one, all 16-bit ones in one,
// all floats in one, all row scales in one, and the shapes in JSON. Internal to package/.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "operators/quantised.h"
#include "package/gltf_writer.h"
#include "scene/gltf_document.h"

namespace prt {

/// {"shapes": [[rows, cols, bits], ...], "int8": accessor, "int16": …, "float32": …, "scales": …};
/// an accessor that would be empty is left out. Value (i, j) of a matrix is its integer (the
/// normalised accessor's value × 127 or 32767) times scale i. Matrices of no entries have no
/// scales.
nlohmann::json write_matrices(std::span<const QuantisedMatrix* const> matrices, GltfWriter& writer);

/// Inverse; throws UserError naming `list` unless the shapes use up the accessors exactly.
std::vector<QuantisedMatrix> read_matrices(const gltf::Document& document, const gltf::Value& list);

/// A whole array of values of type T with `components` per element, as stored in the file (integers
/// not scaled). Throws UserError naming `accessor` if it is of another type or has gaps.
template <typename T>
std::vector<T> read_array(const gltf::Document& document, const gltf::Value& accessor,
                          unsigned components = 1);

}  // namespace prt
