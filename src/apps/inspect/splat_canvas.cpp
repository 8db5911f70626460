#include "apps/inspect/splat_canvas.h"

#include <Eigen/Geometry>

#include "base/error.h"

namespace prt {

namespace {

struct Bounds {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
};

Bounds bounds_of(const SampleSet& samples, std::uint32_t begin, std::uint32_t end) {
  if (begin >= end) throw UserError("the bake has no samples to draw");
  Bounds bounds;
  for (std::uint32_t s = begin; s < end; ++s) {
    const Vec3f& p = samples.positions[s];
    if (!p.allFinite()) throw UserError("the bake has a sample that is not finite");
    bounds.low = bounds.low.cwiseMin(p);
    bounds.high = bounds.high.cwiseMax(p);
  }
  return bounds;
}

}  // namespace

SplatCamera make_splat_camera(const SampleSet& samples, std::uint32_t begin, std::uint32_t end,
                              const Vec3f& towards, float half_view, int width, int height) {
  const Bounds bounds = bounds_of(samples, begin, end);
  SplatCamera camera;
  const Vec3f across = Vec3f::UnitY().cross(towards);
  const Vec3f right = across.norm() > 1e-3F ? Vec3f(across.normalized()) : Vec3f::UnitX();
  camera.axes << right.transpose(), towards.cross(right).normalized().transpose(),
      towards.transpose();
  camera.focal = 0.5F * static_cast<float>(height) / half_view;
  camera.centre_x = 0.5F * static_cast<float>(width);
  camera.centre_y = 0.5F * static_cast<float>(height);
  const float radius = std::max(0.5F * (bounds.high - bounds.low).norm(), 1e-3F);
  // Close enough that the corners of the bounding box just fit.
  const Vec3f centre = 0.5F * (bounds.low + bounds.high);
  const float half_width = half_view * static_cast<float>(width) / static_cast<float>(height);
  float distance = 0.0F;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3f choice((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0);
    const Vec3f p = bounds.low + choice.cwiseProduct(bounds.high - bounds.low) - centre;
    const Vec3f local = camera.axes * p;
    distance = std::max({distance, local.z() + std::abs(local.x()) / half_width,
                         local.z() + std::abs(local.y()) / half_view});
  }
  camera.eye = centre + std::max(1.04F * distance, 1.01F * radius) * towards;
  return camera;
}

Vec3f most_seen_from(const SampleSet& samples) {
  constexpr int kViews = 8;
  constexpr float kElevation = 0.75F;  // as tangent
  Vec3f best = Vec3f::UnitZ();
  float most = -1.0F;
  for (int i = 0; i < kViews; ++i) {
    const float angle = 2.0F * kPi * (static_cast<float>(i) + 0.4F) / kViews;
    const Vec3f view = Vec3f(std::cos(angle), kElevation, std::sin(angle)).normalized();
    float shown = 0.0F;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const float weight = samples.radii[s] * samples.radii[s];
      shown += weight * std::max(0.0F, samples.normals[s].dot(view));
    }
    if (shown > most) {
      most = shown;
      best = view;
    }
  }
  return best;
}

}  // namespace prt
