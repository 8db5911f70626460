#include "scene/gltf_extent.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/gltf_primitive.h"
#include "scene/load.h"

namespace prt::gltf {
namespace {

/// Diagonals between the world's origin and a scene's centre, beyond which the scene gets its own.
constexpr double kOrdinaryDistance = 16.0;

/// Half the spacing of float numbers of that size.
double half_spacing(double value) {
  const auto rounded = static_cast<float>(value);
  return 0.5 * (std::nextafter(rounded, kInfinity) - rounded);
}

/// One primitive's part of the extent.
class Measure {
 public:
  Measure(const Primitive& primitive, const WorldNode& node, Extent& extent)
      : primitive_(primitive), linear_(node.linear()), extent_(extent) {}

  void add_all() {
    for (const Primitive::Corners& corners : primitive_.triangles) add(corners);
    // Integers have no coarse places: a mesh that is stored in them spans its own range.
    if (primitive_.positions.component_type() != ComponentType::kFloat) return;
    const Vec3d spacing = largest_.unaryExpr(&half_spacing);
    const double rounding = (linear_.cwiseAbs() * spacing).maxCoeff();
    if (!(rounding > extent_.vertex_rounding)) return;
    extent_.vertex_rounding = rounding;
    extent_.vertex_distance = distance_;
  }

 private:
  void add(const Primitive::Corners& corners) {
    std::array<Vec3d, 3> places;
    for (std::size_t k = 0; k < 3; ++k) {
      places[k] = primitive_.position(corners[k]);
      if (!places[k].allFinite()) return;  // such a triangle is left out
    }
    for (std::size_t k = 0; k < 3; ++k) expect_within_reach(corners[k], places[k]);
    // One without area is left out, too: a forgotten point at the origin would hide that all else
    // is far away.
    if ((places[1] - places[0]).cross(places[2] - places[0]).isZero(0.0)) return;
    for (std::size_t k = 0; k < 3; ++k) add(corners[k], places[k]);
  }

  void expect_within_reach(std::uint32_t vertex, const Vec3d& place) const {
    if (place.cwiseAbs().maxCoeff() > kFarthestCoordinate) {
      primitive_.json["attributes"]["POSITION"].fail(
          fmt::format("vertex {} lies beyond {} m; check its values and the node's transform",
                      vertex, kFarthestCoordinate));
    }
  }

  void add(std::uint32_t vertex, const Vec3d& place) {
    extent_.low = extent_.low.cwiseMin(place);
    extent_.high = extent_.high.cwiseMax(place);
    const Vec3d stored = vector3(primitive_.positions, vertex);
    largest_ = largest_.cwiseMax(stored.cwiseAbs());
    distance_ = std::max(distance_, (linear_ * stored).norm());
  }

  const Primitive& primitive_;
  Eigen::Matrix3d linear_;
  Extent& extent_;
  Vec3d largest_ = Vec3d::Zero();  // of the stored coordinates, without sign
  double distance_ = 0.0;
};

}  // namespace

Extent measure_extent(const Document& document, const std::vector<WorldNode>& nodes) {
  Extent extent;
  std::uint64_t triangles = 0;
  for (const WorldNode& node : nodes) {
    if (node.node->mesh < 0 || node.singular()) continue;
    for (const MeshPrimitive& given : mesh_primitives(document, node)) {
      if (!given.has_triangles()) continue;
      const Primitive primitive(document, node, *given.from, given.json);
      triangles += primitive.triangles.size();
      if (triangles > kMaxTriangles) {
        given.json.fail(fmt::format("the scene has more than {} triangles", kMaxTriangles));
      }
      Measure(primitive, node, extent).add_all();
    }
  }
  return extent;
}

Vec3d choose_origin(const Extent& extent) {
  const double diagonal = extent.diagonal();
  const Vec3d centre = extent.centre();
  if (extent.empty() || !(centre.norm() > kOrdinaryDistance * diagonal)) return Vec3d::Zero();
  int exponent = 0;
  static_cast<void>(std::frexp(2.0 * diagonal, &exponent));
  const double step = std::ldexp(1.0, exponent);
  const Vec3d steps = (centre / step).array().round();
  return step * steps + Vec3d::Zero();  // no negative zeros
}

}  // namespace prt::gltf
