#include "store/quantised_io.h"

namespace prt {

namespace {

template <typename T>
void put_integers(Artifact& artifact, const std::string& name, const std::vector<T>& values,
                  const QuantisedMatrix& matrix, const std::string& units,
                  const std::string& meaning) {
  artifact.put(name, std::span<const T>(values), {matrix.rows, matrix.cols}, units, meaning);
}

}  // namespace

void put_quantised(Artifact& artifact, const std::string& name, const QuantisedMatrix& matrix,
                   const std::string& units, const std::string& meaning) {
  // Integers have no unit of their own: the scale carries it.
  if (matrix.bits == 8) {
    put_integers(artifact, name, matrix.int8, matrix, "1", meaning);
  } else if (matrix.bits == 16) {
    put_integers(artifact, name, matrix.int16, matrix, "1", meaning);
  } else {
    put_integers(artifact, name, matrix.float32, matrix, units, meaning);
  }
  artifact.put(name + ".scale", std::span<const float>(matrix.scales), {matrix.rows},
               matrix.bits == 32 ? "1" : units, "value of integer 1 in each row of " + name);
}

QuantisedMatrix get_quantised(const Artifact& artifact, const std::string& name) {
  const Dataset& data = artifact.at(name);
  if (data.dims.size() != 2) throw UnsoundData("array " + name + " is not a matrix");
  QuantisedMatrix matrix;
  matrix.rows = static_cast<std::uint32_t>(data.dims[0]);
  matrix.cols = static_cast<std::uint32_t>(data.dims[1]);
  if (data.type == ElementType::kInt8) {
    matrix.bits = 8;
    matrix.int8 = artifact.vector<std::int8_t>(name);
  } else if (data.type == ElementType::kInt16) {
    matrix.bits = 16;
    matrix.int16 = artifact.vector<std::int16_t>(name);
  } else {
    matrix.bits = 32;
    matrix.float32 = artifact.vector<float>(name);
  }
  matrix.scales = artifact.vector<float>(name + ".scale");
  if (matrix.scales.size() != matrix.rows) {
    throw UnsoundData("array " + name + ".scale does not have one value per row of " + name);
  }
  return matrix;
}

}  // namespace prt
