#include "player/set_up.h"

#include <array>

namespace prt {
namespace {

struct Box {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
  [[nodiscard]] Vec3f at(float x, float y, float z) const {
    return low + Vec3f(x, y, z).cwiseProduct(high - low);
  }
  [[nodiscard]] float diagonal() const { return (high - low).norm(); }
};

Box samples_box(const SampleSet& samples) {
  Box box;
  for (const Vec3f& p : samples.positions) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

/// Share of the sampled area that sees p from its front and lies on the side of `ahead` (all if
/// zero).
double seen_share(const Evaluator& evaluator, const Vec3f& p, const Vec3f& ahead) {
  const SampleSet& samples = evaluator.package().samples;
  Light light;
  light.position = p;
  const std::vector<float> visibility = evaluator.visibility(light);
  double seen = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    total += samples.areas[i];
    const bool in_view =
        ahead.isZero() || ahead.dot((samples.positions[i] - p).normalized()) > 0.6F;
    if (visibility[i] > 0.0F && in_view) seen += double(visibility[i]) * samples.areas[i];
  }
  return total > 0.0 ? seen / total : 0.0;
}

/// A place from which less than this share is seen lies in a solid or outside.
constexpr double kFreeShare = 0.02;

SceneCamera outside_camera(const Box& box) {
  SceneCamera camera;
  camera.target = box.at(0.5F, 0.5F, 0.5F);
  camera.eye = camera.target + 1.1F * box.diagonal() * Vec3f(0.5F, 0.5F, 0.7F).normalized();
  return camera;
}

}  // namespace

Light to_light(const SceneLight& light) {
  Light played;
  played.kind = light.kind == SceneLight::Kind::kPoint  ? Light::Kind::kPoint
                : light.kind == SceneLight::Kind::kSpot ? Light::Kind::kSpot
                                                        : Light::Kind::kSun;
  played.position = light.position;
  played.direction = light.direction;
  played.intensity = light.intensity;
  played.inner_angle = light.inner_angle;
  played.outer_angle = light.outer_angle;
  return played;
}

Light default_light(const Evaluator& evaluator) {
  if (!evaluator.package().scene.lights.empty()) {
    return to_light(evaluator.package().scene.lights.front());
  }
  const Box box = samples_box(evaluator.package().samples);
  Light light;
  light.position = box.at(0.5F, 0.7F, 0.5F);
  double best = 0.0;
  for (const float y : {0.5F, 0.7F, 0.85F}) {
    for (const float x : {0.5F, 0.35F, 0.65F, 0.2F, 0.8F}) {
      for (const float z : {0.5F, 0.35F, 0.65F, 0.2F, 0.8F}) {
        const Vec3f p = box.at(x, y, z);
        const double share = seen_share(evaluator, p, Vec3f::Zero());
        if (share > best) {
          best = share;
          light.position = p;
        }
      }
    }
  }
  // Irradiance of about 10 W/m² a quarter of the box away.
  const float distance = 0.25F * box.diagonal();
  light.intensity = Vec3f::Constant(10.0F * distance * distance);
  return light;
}

Environment default_environment() {
  return parse_environment("gradient:0.5,0.8,1.5:1,1,1:0.2,0.18,0.15");
}

SceneCamera default_camera(const Evaluator& evaluator) {
  if (evaluator.package().scene.camera) return *evaluator.package().scene.camera;
  const Box box = samples_box(evaluator.package().samples);
  const Vec3f size = box.high - box.low;
  const bool along_x = size.x() >= size.z();
  SceneCamera camera = outside_camera(box);
  double best = kFreeShare;
  for (const float end : {0.1F, 0.9F, 0.25F, 0.75F}) {
    const Vec3f ahead = (end < 0.5F ? 1.0F : -1.0F) * (along_x ? Vec3f::UnitX() : Vec3f::UnitZ());
    for (const float y : {0.4F, 0.55F, 0.25F, 0.7F}) {
      for (const float side : {0.5F, 0.35F, 0.65F, 0.2F, 0.8F}) {
        const Vec3f eye = along_x ? box.at(end, y, side) : box.at(side, y, end);
        const double share = seen_share(evaluator, eye, ahead);
        if (share <= best) continue;
        best = share;
        camera.eye = eye;
        camera.target = eye + ahead - Vec3f(0, 0.08F, 0);
        camera.vertical_fov = 1.05F;
      }
    }
  }
  return camera;
}

}  // namespace prt
