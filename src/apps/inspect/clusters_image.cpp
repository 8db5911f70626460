#include "apps/inspect/clusters_image.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace prt {

namespace {

constexpr int kSupersampling = 2;   // per axis
constexpr float kHalfView = 0.35F;  // tangent of half the vertical field of view
const Colour kBackground(0.97F, 0.97F, 0.97F);

struct Camera {
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

struct Bounds {
  Vec3f low = Vec3f::Constant(kInfinity);
  Vec3f high = Vec3f::Constant(-kInfinity);
};

Bounds bounds_of(const SampleSet& samples) {
  if (samples.size() == 0) throw UserError("the bake has no samples to draw");
  Bounds bounds;
  for (const Vec3f& p : samples.positions) {
    if (!p.allFinite()) throw UserError("the bake has a sample that is not finite");
    bounds.low = bounds.low.cwiseMin(p);
    bounds.high = bounds.high.cwiseMax(p);
  }
  return bounds;
}

/// Of eight views from above, the one towards which the samples turn most area.
Vec3f best_direction(const SampleSet& samples) {
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

Camera make_camera(const SampleSet& samples, int width, int height) {
  const Bounds bounds = bounds_of(samples);
  const Vec3f towards = best_direction(samples);
  Camera camera;
  const Vec3f right = Vec3f::UnitY().cross(towards).normalized();
  camera.axes << right.transpose(), towards.cross(right).transpose(), towards.transpose();
  camera.focal = 0.5F * static_cast<float>(height) / kHalfView;
  camera.centre_x = 0.5F * static_cast<float>(width);
  camera.centre_y = 0.5F * static_cast<float>(height);
  const float radius = std::max(0.5F * (bounds.high - bounds.low).norm(), 1e-3F);
  // Close enough that the corners of the bounding box just fit.
  const Vec3f centre = 0.5F * (bounds.low + bounds.high);
  const float half_width = kHalfView * static_cast<float>(width) / static_cast<float>(height);
  float distance = 0.0F;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3f choice((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0);
    const Vec3f p = bounds.low + choice.cwiseProduct(bounds.high - bounds.low) - centre;
    const Vec3f local = camera.axes * p;
    distance = std::max({distance, local.z() + std::abs(local.x()) / half_width,
                         local.z() + std::abs(local.y()) / kHalfView});
  }
  camera.eye = centre + std::max(1.04F * distance, 1.01F * radius) * towards;
  return camera;
}

/// Colours with depths; nearer wins.
class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width),
        height_(height),
        colours_(std::size_t(width) * std::size_t(height), kBackground),
        depths_(colours_.size(), kInfinity) {}

  /// A disk of radius (m) about a sample.
  void splat(const Camera& camera, const Vec3f& p, const Vec3f& n, float radius,
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
  void dot(const Camera& camera, const Vec3f& p, const Vec3f& n, float pixels, float nearer) {
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
  /// Averages blocks of kSupersampling² pixels.
  [[nodiscard]] Picture picture() const {
    Picture out(width_ / kSupersampling, height_ / kSupersampling, kBackground);
    for (int y = 0; y < out.height(); ++y) {
      for (int x = 0; x < out.width(); ++x) {
        Colour sum = Colour::Zero();
        for (int k = 0; k < kSupersampling * kSupersampling; ++k) {
          sum += colours_[at(x * kSupersampling + k % kSupersampling,
                             y * kSupersampling + k / kSupersampling)];
        }
        out.set(x, y, sum / (kSupersampling * kSupersampling));
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

}  // namespace

Picture draw_clusters(const SampleSet& samples, std::span<const std::uint32_t> roots, int width,
                      int height) {
  // Disks of the Poisson radius about each sample overlap enough to leave few gaps.
  constexpr float kReach = 1.0F;
  constexpr float kDotPixels = 5.0F;
  const Camera camera = make_camera(samples, width * kSupersampling, height * kSupersampling);
  Canvas canvas(width * kSupersampling, height * kSupersampling);
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const Colour colour = index_colour(static_cast<std::uint32_t>(c));
    for (std::uint32_t s = samples.cluster_begin[c]; s < samples.cluster_begin[c + 1]; ++s) {
      const Vec3f view = (camera.eye - samples.positions[s]).normalized();
      const float facing = std::max(0.0F, samples.normals[s].dot(view));
      canvas.splat(camera, samples.positions[s], samples.normals[s], kReach * samples.radii[s],
                   (0.55F + 0.45F * facing) * colour);
    }
  }
  for (const std::uint32_t root : roots) {
    if (root >= samples.size()) continue;
    canvas.dot(camera, samples.positions[root], samples.normals[root], kDotPixels * kSupersampling,
               samples.radii[root]);
  }
  return canvas.picture();
}

}  // namespace prt
