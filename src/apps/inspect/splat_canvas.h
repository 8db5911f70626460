// Samples as disks, with hidden ones behind: what all pictures of a bake's surface are drawn with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "apps/inspect/drawing.h"
#include "domains/samples.h"

namespace prt {

inline constexpr int kSplatSupersampling = 2;  // per axis
inline const Colour kSplatBackground(0.97F, 0.97F, 0.97F);

struct SplatCamera {
  Vec3f eye;
  Mat3f axes;          ///< rows: right, up, towards the eye
  float focal = 1.0F;  ///< pixels at distance 1
  float centre_x = 0.0F, centre_y = 0.0F;

  /// Pixel coordinates and depth along the view, > 0 in front.
  [[nodiscard]] Vec3f project(const Vec3f& p) const {
    const Vec3f local = axes * (p - eye);
    const float depth = -local.z();
    return {centre_x + focal * local.x() / depth, centre_y - focal * local.y() / depth, depth};
  }
  /// Not normalised: its depth is 1.
  [[nodiscard]] Vec3f direction(float x, float y) const {
    return axes.transpose() * Vec3f((x - centre_x) / focal, (centre_y - y) / focal, -1.0F);
  }
};

/// A camera that looks along -towards (unit) and sees samples [begin, end) as large as fits in
/// width × height pixels. `half_view`: tangent of half the vertical field of view; a small one
/// looks from afar. Throws UserError if there is no sample or one is not finite.
SplatCamera make_splat_camera(const SampleSet& samples, std::uint32_t begin, std::uint32_t end,
                              const Vec3f& towards, float half_view, int width, int height);

/// Of eight views from above, the one towards which the samples turn most area.
Vec3f most_seen_from(const SampleSet& samples);

/// Colours with depths; nearer wins.
class SplatCanvas {
 public:
  SplatCanvas(int width, int height, const Colour& background = kSplatBackground)
      : width_(width),
        height_(height),
        colours_(std::size_t(width) * std::size_t(height), background),
        depths_(colours_.size(), kInfinity) {}

  /// A disk of radius (m) about a sample.
  void splat(const SplatCamera& camera, const Vec3f& p, const Vec3f& n, float radius,
             const Colour& colour) {
    const Vec3f to_eye = camera.eye - p;
    if (n.dot(to_eye) <= 0.0F) return;  // back face
    const Vec3f pixel = camera.project(p);
    const float reach = camera.focal * radius / std::max(pixel.z() - radius, 1e-3F * pixel.z());
    for_pixels(pixel, reach, [&](int x, int y) {
      const Vec3f d = camera.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
      const float depth = -n.dot(to_eye) / n.dot(d);
      if (!(depth > 0.0F) || (camera.eye + depth * d - p).squaredNorm() > radius * radius) return;
      set(x, y, depth, colour);
    });
  }
  /// A round dot of some pixels, in front of what is about as near.
  void dot(const SplatCamera& camera, const Vec3f& p, const Vec3f& n, float pixels, float nearer) {
    if (n.dot(camera.eye - p) <= 0.0F) return;
    const Vec3f pixel = camera.project(p);
    for_pixels(pixel, pixels, [&](int x, int y) {
      const float off = std::hypot(static_cast<float>(x) + 0.5F - pixel.x(),
                                   static_cast<float>(y) + 0.5F - pixel.y());
      if (off > pixels) return;
      const bool rim = off > 0.65F * pixels;
      set(x, y, pixel.z() - nearer, rim ? Colour::Zero() : Colour::Ones());
    });
  }
  /// Averages blocks of kSplatSupersampling² pixels.
  [[nodiscard]] Drawing drawing() const {
    Drawing out(width_ / kSplatSupersampling, height_ / kSplatSupersampling, kSplatBackground);
    for (int y = 0; y < out.height(); ++y) {
      for (int x = 0; x < out.width(); ++x) {
        Colour sum = Colour::Zero();
        for (int k = 0; k < kSplatSupersampling * kSplatSupersampling; ++k) {
          sum += colours_[at(x * kSplatSupersampling + k % kSplatSupersampling,
                             y * kSplatSupersampling + k / kSplatSupersampling)];
        }
        out.set(x, y, sum / (kSplatSupersampling * kSplatSupersampling));
      }
    }
    return out;
  }

 private:
  [[nodiscard]] std::size_t at(int x, int y) const {
    return std::size_t(y) * std::size_t(width_) + std::size_t(x);
  }
  void set(int x, int y, float depth, const Colour& colour) {
    if (depth >= depths_[at(x, y)]) return;
    depths_[at(x, y)] = depth;
    colours_[at(x, y)] = colour;
  }
  template <typename Visit>
  void for_pixels(const Vec3f& centre, float reach, Visit&& visit) const {
    if (!(centre.z() > 0.0F)) return;
    const auto clamped = [](float v, int most) {
      return static_cast<int>(std::clamp(v, 0.0F, static_cast<float>(most)));
    };
    const int x_end = clamped(std::ceil(centre.x() + reach), width_);
    const int y_end = clamped(std::ceil(centre.y() + reach), height_);
    for (int y = clamped(std::floor(centre.y() - reach), height_); y < y_end; ++y) {
      for (int x = clamped(std::floor(centre.x() - reach), width_); x < x_end; ++x) visit(x, y);
    }
  }

  int width_, height_;
  std::vector<Colour> colours_;
  std::vector<float> depths_;
};

}  // namespace prt
