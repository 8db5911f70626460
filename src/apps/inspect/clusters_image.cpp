#include "apps/inspect/clusters_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/inspect/splat_canvas.h"
#include "base/error.h"

namespace prt {

namespace {

constexpr float kHalfView = 0.35F;  // tangent of half the vertical field of view
const Colour kUnknown(0.6F, 0.6F, 0.6F);

/// Each cluster in its colour, darker where it is seen at an angle.
Drawing draw_coloured(const SampleSet& samples, std::span<const Colour> colours,
                      std::span<const std::uint32_t> roots, int width, int height) {
  // Disks of the Poisson radius about each sample overlap enough to leave few gaps.
  constexpr float kReach = 1.0F;
  constexpr float kDotPixels = 5.0F;
  const int wide = width * kSplatSupersampling;
  const int high = height * kSplatSupersampling;
  const SplatCamera camera =
      make_splat_camera(samples, 0, static_cast<std::uint32_t>(samples.size()),
                        most_seen_from(samples), kHalfView, wide, high);
  SplatCanvas canvas(wide, high);
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    for (std::uint32_t s = samples.cluster_begin[c]; s < samples.cluster_begin[c + 1]; ++s) {
      const Vec3f view = (camera.eye - samples.positions[s]).normalized();
      const float facing = std::max(0.0F, samples.normals[s].dot(view));
      canvas.splat(camera, samples.positions[s], samples.normals[s], kReach * samples.radii[s],
                   (0.55F + 0.45F * facing) * colours[c]);
    }
  }
  for (const std::uint32_t root : roots) {
    if (root >= samples.size()) continue;
    canvas.dot(camera, samples.positions[root], samples.normals[root],
               kDotPixels * kSplatSupersampling, samples.radii[root]);
  }
  return canvas.drawing();
}

}  // namespace

Drawing draw_clusters(const SampleSet& samples, std::span<const std::uint32_t> roots, int width,
                      int height) {
  std::vector<Colour> colours;
  for (std::uint32_t c = 0; c < samples.clusters(); ++c) colours.push_back(index_colour(c));
  return draw_coloured(samples, colours, roots, width, height);
}

Drawing draw_values(const SampleSet& samples, const ClusterValues& values, int width, int height) {
  if (values.of_cluster.size() != samples.clusters()) {
    throw UnsoundData(values.title + ": not one value for each cluster of the samples");
  }
  std::vector<Colour> colours;
  for (const double v : values.of_cluster) {
    const bool known = std::isfinite(v);
    colours.push_back(known ? ramp_colour(static_cast<float>(values.place(v))) : kUnknown);
  }
  return draw_coloured(samples, colours, {}, width, height);
}

void draw_legend(Drawing& drawing, const ClusterValues& values) {
  constexpr int kMargin = 24, kWidth = 360, kHeight = 16, kLetter = 12;
  const int top = drawing.height() - 64;
  drawing.fill(kMargin - 12, top - 32, kWidth + 24, 88, Colour::Ones());
  drawing.text(kMargin, top - 22, values.title, kInk);
  for (int x = 0; x < kWidth; ++x) {
    const float t = (static_cast<float>(x) + 0.5F) / kWidth;
    drawing.fill(kMargin + x, top, 1, kHeight, ramp_colour(t));
  }
  for (int i = 0; i < 3; ++i) {
    const std::string label = values.text(values.low + 0.5 * i * (values.high - values.low));
    const int length = kLetter * static_cast<int>(label.size());
    drawing.text(kMargin + i * (kWidth - length) / 2, top + kHeight + 8, label, kInk);
  }
}

}  // namespace prt
