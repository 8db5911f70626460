#include "evaluate/error_picture.h"

#include <algorithm>
#include <cmath>

#include "player/visible_surfaces.h"

namespace prt {
namespace {

constexpr int kScaleHeight = 12;  // pixels
const Vec3f kTooBright(0.78F, 0.12F, 0.10F);
const Vec3f kTooDark(0.10F, 0.25F, 0.75F);
const Vec3f kRight(0.97F, 0.97F, 0.97F);
const Vec3f kNotReached(0.25F, 0.25F, 0.25F);
const Vec3f kNotFinite(0.95F, 0.85F, 0.10F);
const Vec3f kNothing(0.08F, 0.08F, 0.10F);

/// Of an error in [-1, 1], sRGB; beyond it stays the strongest.
Vec3f colour_of(float error) {
  if (std::isnan(error)) return kNotFinite;
  const float strength = std::min(1.0F, std::abs(error));
  return kRight + strength * ((error > 0.0F ? kTooBright : kTooDark) - kRight);
}

class Canvas {
 public:
  explicit Canvas(const ErrorPictureSettings& settings) {
    picture_.width = 2 * settings.width;
    picture_.height = settings.height + kScaleHeight;
    picture_.rgb.resize(3 * static_cast<std::size_t>(picture_.width) *
                        static_cast<std::size_t>(picture_.height));
    for (int y = 0; y < picture_.height; ++y) {
      for (int x = 0; x < picture_.width; ++x) {
        const float at = 2.0F * (static_cast<float>(x) + 0.5F) / static_cast<float>(picture_.width);
        set(x, y, y < settings.height ? kNothing : colour_of(at - 1.0F));
      }
    }
  }
  void set(int x, int y, const Vec3f& colour) {
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
        static_cast<std::size_t>(x);
    for (std::size_t c = 0; c < 3; ++c) {
      picture_.rgb[3 * pixel + c] =
          static_cast<std::uint8_t>(std::lround(255.0F * colour[static_cast<Eigen::Index>(c)]));
    }
  }
  Picture& picture() { return picture_; }

 private:
  Picture picture_;
};

float grey(const Vec3f& v) { return v.mean(); }

/// Means over the neighbours of each pixel that lie on the same surface: the noise of the reference
/// would hide what indirect light, which is smooth, has wrong.
std::vector<float> smoothed(const std::vector<float>& values, const VisibleSurfaces& surfaces,
                            int width, int height) {
  constexpr int kReach = 4;  // pixels
  constexpr float kAlike = 0.95F;
  std::vector<std::uint32_t> at(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                                kNone);
  for (std::uint32_t i = 0; i < surfaces.place.size(); ++i) at[surfaces.place[i]] = i;
  const auto same_surface = [&](const PlayPoint& a, const PlayPoint& b) {
    const Vec3f between = b.position - a.position;
    return a.normal.dot(b.normal) > kAlike &&
           std::abs(between.dot(a.normal)) <= (1.0F - kAlike) * between.norm();
  };
  std::vector<float> means(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int x0 = static_cast<int>(surfaces.place[i]) % width;
    const int y0 = static_cast<int>(surfaces.place[i]) / width;
    float sum = 0.0F;
    int count = 0;
    for (int y = std::max(0, y0 - kReach); y <= std::min(height - 1, y0 + kReach); ++y) {
      for (int x = std::max(0, x0 - kReach); x <= std::min(width - 1, x0 + kReach); ++x) {
        const std::uint32_t j = at[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(x)];
        if (j == kNone || !std::isfinite(values[j])) continue;
        if (!same_surface(surfaces.points[i], surfaces.points[j])) continue;
        sum += values[j];
        ++count;
      }
    }
    means[i] = std::isfinite(values[i]) ? sum / static_cast<float>(count) : values[i];
  }
  return means;
}

}  // namespace

Picture draw_error(const Evaluator& player, const ReferenceInputs& inputs, const Light& light,
                   const SceneCamera& camera, const ErrorPictureSettings& settings) {
  const FragmentImage image = rasterise(inputs.scene, camera, settings.width, settings.height);
  const VisibleSurfaces surfaces = visible_surfaces(inputs.scene, camera.eye, image, 0);
  std::vector<PlayPoint> shown = surfaces.points;
  std::vector<ReceiverPoint> asked;
  for (PlayPoint& p : shown) {
    p.shading_normal = p.normal;  // irradiance is judged on the geometry
    asked.push_back({p.position, p.normal});
  }
  const auto played = player.reconstruct(player.evaluate({&light, 1}), shown);
  const auto traced = trace_in_parallel(inputs.scene, inputs.caster, {&light, 1}, asked,
                                        {.paths = settings.paths}, settings.stream, 0, [] {});
  Canvas canvas(settings);
  for (const bool direct : {true, false}) {
    double sum = 0.0;
    for (const IrradianceEstimate& e : traced) {
      sum += grey(direct ? e.mean_direct() : e.mean_indirect());
    }
    const auto mean = static_cast<float>(sum / std::max<double>(1.0, double(traced.size())));
    std::vector<float> errors;
    for (std::size_t i = 0; i < traced.size(); ++i) {
      const float truth = grey(direct ? traced[i].mean_direct() : traced[i].mean_indirect());
      const float value = grey(direct ? played[i].direct : played[i].indirect);
      if (!std::isfinite(value)) ++canvas.picture().not_finite;
      // In the dark any light is wrong.
      const float off = value - truth;
      errors.push_back(off == 0.0F ? 0.0F : off / (kStrongestError * mean));
    }
    if (!direct) errors = smoothed(errors, surfaces, settings.width, settings.height);
    for (std::size_t i = 0; i < traced.size(); ++i) {
      const int place = static_cast<int>(surfaces.place[i]);
      canvas.set(place % settings.width + (direct ? 0 : settings.width), place / settings.width,
                 played[i].reached ? colour_of(errors[i]) : kNotReached);
    }
  }
  canvas.picture().covered = traced.size();
  return std::move(canvas.picture());
}

}  // namespace prt
