#include "store/artifact.h"

namespace prt {

std::size_t element_size(ElementType type) {
  switch (type) {
    case ElementType::kInt8:
    case ElementType::kUint8:
      return 1;
    case ElementType::kInt16:
    case ElementType::kUint16:
      return 2;
    case ElementType::kUint32:
    case ElementType::kFloat32:
      return 4;
    case ElementType::kUint64:
    case ElementType::kFloat64:
      return 8;
  }
  throw std::logic_error("unknown element type");
}

const Dataset& Artifact::at(const std::string& name) const {
  const auto it = datasets.find(name);
  if (it == datasets.end()) throw UnsoundData("array " + name + " is missing");
  return it->second;
}

std::vector<Vec3f> Artifact::points(const std::string& name) const {
  const auto v = values<float>(name);
  const Dataset& d = at(name);
  if (d.dims.size() != 2 || d.dims[1] != 3) throw UnsoundData("array " + name + " is not n x 3");
  std::vector<Vec3f> out(d.dims[0]);
  if (!out.empty()) std::memcpy(out[0].data(), v.data(), v.size_bytes());
  return out;
}

MatrixF Artifact::matrix(const std::string& name) const {
  const auto v = values<float>(name);
  const Dataset& d = at(name);
  if (d.dims.size() != 2) throw UnsoundData("array " + name + " is not a matrix");
  return Eigen::Map<const MatrixF>(v.data(), static_cast<Eigen::Index>(d.dims[0]),
                                   static_cast<Eigen::Index>(d.dims[1]));
}

}  // namespace prt
