#include "player/picture.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "base/parallel.h"
#include "player/colours.h"
#include "player/tone.h"
#include "player/visible_surfaces.h"

namespace prt {
namespace {

constexpr std::size_t kGrain = 4096;
std::vector<Vec3f> cluster_colours(const Evaluator& evaluator, const VisibleSurfaces& surfaces,
                                   const Vec3f& eye, unsigned threads) {
  const auto cluster_of = evaluator.package().samples.cluster_of_sample();
  std::vector<Vec3f> colours(surfaces.points.size(), Vec3f::Zero());
  parallel_for(colours.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<SplatWeight> weights;
    for (std::size_t i = begin; i < end; ++i) {
      const PlayPoint& point = surfaces.points[i];
      evaluator.splats().weights_at(point.position, point.normal, weights);
      const auto heaviest = std::max_element(
          weights.begin(), weights.end(),
          [](const SplatWeight& a, const SplatWeight& b) { return a.weight < b.weight; });
      if (heaviest == weights.end()) continue;
      const float facing = std::abs(point.shading_normal.dot((eye - point.position).normalized()));
      colours[i] = (0.4F + 0.6F * facing) * cluster_colour(cluster_of[heaviest->sample]);
    }
  });
  return colours;
}

/// Sides of triangles that have samples: two flags per triangle, back and front.
std::vector<bool> sampled_sides(const Package& package) {
  std::vector<bool> sides(2 * package.scene.triangles.size(), false);
  for (std::size_t i = 0; i < package.samples.size(); ++i) {
    const std::uint32_t t = package.samples.triangles[i];
    const bool front = triangle_normal(package.scene, t).dot(package.samples.normals[i]) > 0.0F;
    sides[2 * t + (front ? 1 : 0)] = true;
  }
  return sides;
}

void count_unreached(const Package& package, const FragmentImage& image,
                     const VisibleSurfaces& surfaces, const std::vector<PlayedIrradiance>& played,
                     Picture& picture) {
  const std::vector<bool> sides = sampled_sides(package);
  picture.covered = played.size();
  for (std::size_t i = 0; i < played.size(); ++i) {
    if (played[i].reached) continue;
    ++picture.unreached;
    const std::uint32_t t = image.fragments[surfaces.place[i]].triangle;
    const bool front = triangle_normal(package.scene, t).dot(surfaces.points[i].normal) > 0.0F;
    if (sides[2 * t + (front ? 1 : 0)]) ++picture.holes;
  }
}

Vec3f clamped_radiance(const Vec3f& albedo, const Vec3f& irradiance) {
  return albedo.cwiseProduct(irradiance).cwiseMax(0.0F) / kPi;
}

/// What a surface mirrors of the environment (SH §7): no paper's physics, and never shadowed.
Vec3f reflected(const PictureSettings& settings, const Vec3f& eye, const PlayPoint& point) {
  const Vec3f view = (point.position - eye).normalized();
  const Vec3f& n = point.shading_normal;
  return settings.reflection * settings.environment->radiance(view - 2.0F * view.dot(n) * n);
}

/// Display colours (linear, [0, 1]) of all surfaces; of a linear picture their radiance.
std::vector<Vec3f> tone_mapped(const VisibleSurfaces& surfaces,
                               const std::vector<PlayedIrradiance>& played,
                               const PictureSettings& settings, const Vec3f& eye,
                               Picture& picture) {
  const bool mirrors = settings.environment != nullptr && settings.reflection > 0.0F;
  std::vector<Vec3f> colours(played.size());
  for (std::size_t i = 0; i < played.size(); ++i) {
    colours[i] = clamped_radiance(surfaces.albedo[i], played[i].direct + played[i].indirect);
    if (mirrors) colours[i] += reflected(settings, eye, surfaces.points[i]);
    if (!colours[i].allFinite()) ++picture.not_finite;
  }
  picture.exposure = settings.exposure ? *settings.exposure : own_exposure(colours);
  for (std::size_t i = 0; i < played.size(); ++i) {
    if (settings.show == Show::kDirect) {
      colours[i] = clamped_radiance(surfaces.albedo[i], played[i].direct);
    } else if (settings.show == Show::kIndirect) {
      colours[i] = clamped_radiance(surfaces.albedo[i], played[i].indirect);
    }
    if (!colours[i].allFinite()) colours[i].setZero();
    if (!settings.linear) colours[i] = filmic(picture.exposure * colours[i]);
  }
  return colours;
}

std::vector<Vec3f> visibility_colours(const std::vector<PlayedIrradiance>& played) {
  std::vector<Vec3f> colours;
  colours.reserve(played.size());
  for (const PlayedIrradiance& p : played) {
    colours.push_back(p.visibility == kUnlit ? unlit_colour() : Vec3f::Constant(p.visibility));
  }
  return colours;
}

/// The mean over the samples of each pixel.
std::vector<Vec3f> pixels_of(const std::vector<Vec3f>& samples, int side, const Picture& picture) {
  const auto width = static_cast<std::size_t>(picture.width);
  const auto across = static_cast<std::size_t>(side);
  std::vector<Vec3f> pixels(width * static_cast<std::size_t>(picture.height));
  for (std::size_t pixel = 0; pixel < pixels.size(); ++pixel) {
    Vec3f sum = Vec3f::Zero();
    for (std::size_t k = 0; k < across * across; ++k) {
      const std::size_t y = (pixel / width) * across + k / across;
      const std::size_t x = (pixel % width) * across + k % across;
      sum += samples[y * width * across + x];
    }
    pixels[pixel] = sum / static_cast<float>(across * across);
  }
  return pixels;
}

bool shows_light(Show show) { return show != Show::kVisibility && show != Show::kClusters; }

/// What lies behind all surfaces, for each picture sample.
std::vector<Vec3f> background(const SceneCamera& camera, const PictureSettings& settings,
                              const Picture& picture) {
  const int side = settings.samples_per_side;
  const int width = settings.width * side, height = settings.height * side;
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (settings.environment == nullptr || !shows_light(settings.show)) {
    return {count, settings.linear ? Vec3f(Vec3f::Zero()) : background_colour()};
  }
  std::vector<Vec3f> samples(count);
  parallel_for(count, kGrain, settings.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto across = static_cast<std::size_t>(width);
      const Vec3f view =
          view_direction(camera, width, height, static_cast<float>(i % across) + 0.5F,
                         static_cast<float>(i / across) + 0.5F);
      samples[i] = settings.environment->radiance(view);
      if (!settings.linear) samples[i] = filmic(picture.exposure * samples[i]);
    }
  });
  return samples;
}

/// As floats, or as sRGB.
void store(const std::vector<Vec3f>& pixels, bool linear, Picture& picture) {
  for (const Vec3f& pixel : pixels) {
    for (const float value : pixel) {
      if (linear) {
        picture.radiance.push_back(value);
      } else {
        picture.rgb.push_back(srgb_byte(value));
      }
    }
  }
}

}  // namespace

Picture render(const Evaluator& evaluator, const SampleIrradiance& irradiance,
               const SceneCamera& camera, const PictureSettings& settings) {
  const Scene& scene = evaluator.package().scene;
  Picture picture;
  picture.width = settings.width;
  picture.height = settings.height;
  const int side = settings.samples_per_side;
  const FragmentImage image =
      rasterise(scene, camera, settings.width * side, settings.height * side, settings.threads);
  const VisibleSurfaces surfaces = visible_surfaces(scene, camera.eye, image, settings.threads);
  const std::vector<PlayedIrradiance> played = evaluator.reconstruct(irradiance, surfaces.points);
  count_unreached(evaluator.package(), image, surfaces, played, picture);
  const std::vector<Vec3f> colours =
      settings.show == Show::kClusters
          ? cluster_colours(evaluator, surfaces, camera.eye, settings.threads)
      : settings.show == Show::kVisibility
          ? visibility_colours(played)
          : tone_mapped(surfaces, played, settings, camera.eye, picture);
  std::vector<Vec3f> samples = background(camera, settings, picture);
  for (std::size_t i = 0; i < colours.size(); ++i) samples[surfaces.place[i]] = colours[i];
  store(pixels_of(samples, side, picture), settings.linear, picture);
  return picture;
}

}  // namespace prt
