#include "player/rasteriser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/error.h"
#include "base/parallel.h"
#include "player/view.h"

namespace prt {
namespace {

constexpr int kLargestSide = 16384;
/// Positions are rounded to this part of a pixel, so that edges are exact in integers.
constexpr std::int64_t kSubpixels = 256;
/// Triangles are clipped at this many half-images from the centre: far enough that clipping is
/// rare, near enough that 64-bit edge functions cannot overflow.
constexpr double kGuardBand = 8.0;
/// Nearest visible depth as a share of the scene's diagonal.
constexpr double kNearShare = 1e-5;
/// Rows drawn by one piece of parallel work.
constexpr std::size_t kBandRows = 32;

/// A corner while it is clipped: projected, with its barycentric weights in the whole triangle.
struct Corner {
  Projected at;
  double u = 0.0;
  double v = 0.0;
};

Corner blend(const Corner& inside, const Corner& outside, double t) {
  const auto mix = [t](double a, double b) { return a + t * (b - a); };
  return {{mix(inside.at.x, outside.at.x), mix(inside.at.y, outside.at.y),
           mix(inside.at.w, outside.at.w)},
          mix(inside.u, outside.u),
          mix(inside.v, outside.v)};
}

/// The part of a polygon where distance(corner) >= 0. New corners are always made from the inner to
/// the outer end, so two triangles that share an edge get the same one.
template <typename Distance>
void clip(std::vector<Corner>& polygon, const Distance& distance) {
  std::vector<Corner> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner& a = polygon[i];
    const Corner& b = polygon[(i + 1) % polygon.size()];
    const double da = distance(a.at);
    const double db = distance(b.at);
    if (da >= 0.0) kept.push_back(a);
    if (da >= 0.0 && db < 0.0) kept.push_back(blend(a, b, da / (da - db)));
    if (da < 0.0 && db >= 0.0) kept.push_back(blend(b, a, db / (db - da)));
  }
  polygon = std::move(kept);
}

/// A triangle ready to draw: corners in 1/256 pixel, counter-clockwise on a screen with y down, and
/// 1/w, u/w, v/w at each corner.
struct ScreenTriangle {
  std::uint32_t triangle = kNone;
  bool masked = false;
  std::array<std::int64_t, 3> x{}, y{};
  std::array<double, 3> inverse_w{}, u_w{}, v_w{};
  std::int64_t twice_area = 0;
};

/// Twice the signed area of (a, b, p); positive where p is on the inner side of the edge a → b.
std::int64_t edge(const ScreenTriangle& t, int a, int b, std::int64_t px, std::int64_t py) {
  return (t.x[b] - t.x[a]) * (py - t.y[a]) - (t.y[b] - t.y[a]) * (px - t.x[a]);
}

/// Exactly one of the two directions of an edge owns the points on it.
bool owns_edge(const ScreenTriangle& t, int a, int b) {
  const std::int64_t dx = t.x[b] - t.x[a];
  const std::int64_t dy = t.y[b] - t.y[a];
  return dy < 0 || (dy == 0 && dx > 0);
}

class Projector {
 public:
  Projector(const Scene& scene, const SceneCamera& camera, int width, int height)
      : scene_(scene), view_(camera, width, height), width_(width), height_(height) {
    near_ = kNearShare * std::max(scene.diagonal(), 1e-20F);
  }

  /// Appends what is left of a triangle in front of the eye.
  void project(std::uint32_t triangle, std::vector<ScreenTriangle>& out) const {
    const Triangle& t = scene_.triangles[triangle];
    std::vector<Corner> polygon;
    for (int k = 0; k < 3; ++k) {
      polygon.push_back(
          {view_.project(scene_.positions[t.vertex[k]]), k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0});
    }
    clip_to_view(polygon);
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      append({polygon[0], polygon[k - 1], polygon[k]}, triangle, out);
    }
  }

 private:
  void clip_to_view(std::vector<Corner>& polygon) const {
    const double side = kGuardBand * view_.aspect();
    const auto inside = [&](const Projected& p) {
      return p.w >= near_ && std::abs(p.x) <= side * p.w && std::abs(p.y) <= kGuardBand * p.w;
    };
    if (std::all_of(polygon.begin(), polygon.end(),
                    [&](const Corner& c) { return inside(c.at); })) {
      return;
    }
    clip(polygon, [&](const Projected& p) { return p.w - near_; });
    clip(polygon, [&](const Projected& p) { return side * p.w + p.x; });
    clip(polygon, [&](const Projected& p) { return side * p.w - p.x; });
    clip(polygon, [&](const Projected& p) { return kGuardBand * p.w + p.y; });
    clip(polygon, [&](const Projected& p) { return kGuardBand * p.w - p.y; });
  }

  void append(std::array<Corner, 3> corners, std::uint32_t triangle,
              std::vector<ScreenTriangle>& out) const {
    ScreenTriangle t;
    t.triangle = triangle;
    t.masked = scene_.materials[scene_.triangles[triangle].material].alpha_mask;
    const auto set = [&](int k, const Corner& c) {
      t.inverse_w[k] = 1.0 / c.at.w;
      const double px = 0.5 * width_ * (1.0 + c.at.x * t.inverse_w[k] / view_.aspect());
      const double py = 0.5 * height_ * (1.0 + c.at.y * t.inverse_w[k]);
      t.x[k] = std::llround(px * kSubpixels);
      t.y[k] = std::llround(py * kSubpixels);
      t.u_w[k] = c.u * t.inverse_w[k];
      t.v_w[k] = c.v * t.inverse_w[k];
    };
    for (int k = 0; k < 3; ++k) set(k, corners[k]);
    t.twice_area = edge(t, 0, 1, t.x[2], t.y[2]);
    if (t.twice_area < 0) {
      set(1, corners[2]);
      set(2, corners[1]);
      t.twice_area = -t.twice_area;
    }
    if (t.twice_area > 0) out.push_back(t);
  }

  const Scene& scene_;
  View view_;
  int width_;
  int height_;
  double near_;
};

/// First pixel whose centre is at or beyond a subpixel coordinate.
std::int64_t first_pixel(std::int64_t subpixel) {
  return (subpixel - kSubpixels / 2 + kSubpixels - 1) >= 0
             ? (subpixel - kSubpixels / 2 + kSubpixels - 1) / kSubpixels
             : 0;
}

class Band {
 public:
  Band(const Scene& scene, FragmentImage& image, std::int64_t begin, std::int64_t end)
      : scene_(scene),
        image_(image),
        begin_(begin),
        end_(end),
        nearness_(static_cast<std::size_t>((end - begin) * image.width), 0.0) {}

  void draw(const ScreenTriangle& t) {
    const auto [left, right] = std::minmax({t.x[0], t.x[1], t.x[2]});
    const auto [top, bottom] = std::minmax({t.y[0], t.y[1], t.y[2]});
    const std::int64_t y_end = std::min(end_, first_pixel(bottom + 1));
    const std::int64_t x_begin = first_pixel(left);
    const std::int64_t x_end = std::min<std::int64_t>(image_.width, first_pixel(right + 1));
    const std::array<std::int64_t, 3> bias = {
        owns_edge(t, 1, 2) ? 0 : -1, owns_edge(t, 2, 0) ? 0 : -1, owns_edge(t, 0, 1) ? 0 : -1};
    for (std::int64_t y = std::max(begin_, first_pixel(top)); y < y_end; ++y) {
      for (std::int64_t x = x_begin; x < x_end; ++x) {
        const std::int64_t px = x * kSubpixels + kSubpixels / 2;
        const std::int64_t py = y * kSubpixels + kSubpixels / 2;
        const std::array<std::int64_t, 3> inner = {edge(t, 1, 2, px, py), edge(t, 2, 0, px, py),
                                                   edge(t, 0, 1, px, py)};
        if (inner[0] + bias[0] < 0 || inner[1] + bias[1] < 0 || inner[2] + bias[2] < 0) continue;
        shade(t, inner, x, y);
      }
    }
  }

 private:
  void shade(const ScreenTriangle& t, const std::array<std::int64_t, 3>& inner, std::int64_t x,
             std::int64_t y) {
    double inverse_w = 0.0;
    double u = 0.0;
    double v = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double weight = static_cast<double>(inner[k]) / static_cast<double>(t.twice_area);
      inverse_w += weight * t.inverse_w[k];
      u += weight * t.u_w[k];
      v += weight * t.v_w[k];
    }
    double& nearest = nearness_[static_cast<std::size_t>((y - begin_) * image_.width + x)];
    if (!(inverse_w > nearest)) return;
    const Fragment fragment{t.triangle, static_cast<float>(u / inverse_w),
                            static_cast<float>(v / inverse_w)};
    if (t.masked && !opaque_at(scene_, t.triangle, fragment.u, fragment.v)) return;
    nearest = inverse_w;
    image_.fragments[static_cast<std::size_t>(y * image_.width + x)] = fragment;
  }

  const Scene& scene_;
  FragmentImage& image_;
  std::int64_t begin_;
  std::int64_t end_;
  std::vector<double> nearness_;  // 1/w of what the pixel shows so far
};

}  // namespace

FragmentImage rasterise(const Scene& scene, const SceneCamera& camera, int width, int height,
                        unsigned threads) {
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    throw UserError("a picture must have 1 to " + std::to_string(kLargestSide) +
                    " pixels on each side, not " + std::to_string(width) + "x" +
                    std::to_string(height));
  }
  FragmentImage image{width, height, {}};
  image.fragments.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const Projector projector(scene, camera, width, height);
  std::vector<ScreenTriangle> triangles;
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) projector.project(t, triangles);
  parallel_for(static_cast<std::size_t>(height), kBandRows, threads,
               [&](std::size_t begin, std::size_t end) {
                 Band band(scene, image, static_cast<std::int64_t>(begin),
                           static_cast<std::int64_t>(end));
                 for (const ScreenTriangle& t : triangles) band.draw(t);
               });
  return image;
}

}  // namespace prt
