#include "apps/inspect/sky_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/inspect/splat_canvas.h"
#include "bases/spherical_harmonics.h"
#include "scene/environment.h"
#include "store/samples_io.h"

namespace prt {

namespace {

constexpr int kPanel = 150;  // pixels; a function alone gets six times as many each way
constexpr int kAlone = 6;
constexpr int kGap = 10;
constexpr int kHead = 40;
constexpr int kName = 20;
constexpr float kHalfView = 0.35F;       // tangent of half the vertical field of view
const Colour kBehind(0.8F, 0.8F, 0.8F);  // white is zero, and has to show

std::string stage_artifact(std::size_t cluster) { return fmt::format("sky_direct/{:04}", cluster); }

bool has_sky(const BakeReader& bake) {
  return std::ranges::any_of(
      bake.entries(), [](const ManifestEntry& entry) { return entry.task == stage_artifact(0); });
}

void require_sky(const BakeReader& bake) {
  if (has_sky(bake)) return;
  throw UserError(bake.path().string() +
                  ": has no environment layer yet; bake it with methods: [lb, sh] or [sh]");
}

/// samples × order².
MatrixF read_transfer(const BakeReader& bake, const SampleSet& samples) {
  MatrixF all;
  for (std::size_t c = 0; c < samples.clusters(); ++c) {
    const MatrixF part = bake.artifact(stage_artifact(c))->matrix("transfer");
    if (c == 0) all.resize(static_cast<Eigen::Index>(samples.size()), part.cols());
    if (part.rows() != samples.cluster_size(c) || part.cols() != all.cols()) {
      throw UnsoundData(stage_artifact(c) + " does not fit samples");
    }
    all.middleRows(samples.cluster_begin[c], part.rows()) = part;
  }
  return all;
}

Drawing draw_function(const SampleSet& samples, const MatrixF& transfer, Eigen::Index k,
                      float largest, int size) {
  const int fine = size * kSplatSupersampling;
  const SplatCamera camera =
      make_splat_camera(samples, 0, static_cast<std::uint32_t>(samples.size()),
                        most_seen_from(samples), kHalfView, fine, fine);
  SplatCanvas canvas(fine, fine, kBehind);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const float value = transfer(static_cast<Eigen::Index>(s), k);
    canvas.splat(camera, samples.positions[s], samples.normals[s], samples.radii[s],
                 difference_colour(largest > 0.0F ? value / largest : 0.0F));
  }
  return canvas.drawing();
}

std::string name_of(int band, int m) { return fmt::format("{},{}", band, m); }

}  // namespace

Drawing draw_sky_transfer(const BakeReader& bake, std::optional<int> index) {
  require_sky(bake);
  const SampleSet samples = get_samples(*bake.artifact("samples"));
  const MatrixF transfer = read_transfer(bake, samples);
  const auto count = static_cast<int>(transfer.cols());
  const auto order = static_cast<int>(std::lround(std::sqrt(count)));
  if (index && *index >= count) {
    throw UserError(
        fmt::format("--index {}: order {} has {} functions, from 0 on", *index, order, count));
  }
  const float largest = transfer.cwiseAbs().maxCoeff();
  const std::string title =
      fmt::format("transfer of the sky's light, order {}, largest {:.3g}", order, largest);
  if (index) {
    const int size = kAlone * kPanel;
    Drawing drawing(size + 2 * kGap, size + kHead + kGap, kSplatBackground);
    drawing.text(kGap, 14, fmt::format("{}, function {}", title, *index), kInk);
    drawing.paste(kGap, kHead, draw_function(samples, transfer, *index, largest, size));
    return drawing;
  }
  const int across = 2 * order - 1;
  const int step = kPanel + kGap;
  Drawing drawing(std::max(across * step, 5 * step) + kGap, kHead + order * (step + kName) + kGap,
                  kSplatBackground);
  drawing.text(kGap, 14, title, kInk);
  for (int band = 0; band < order; ++band) {
    for (int m = -band; m <= band; ++m) {
      const int left = kGap + (m + order - 1) * step;
      const int top = kHead + band * (step + kName);
      drawing.text(left, top, name_of(band, m), kInk);
      drawing.paste(left, top + kName,
                    draw_function(samples, transfer, sh_index(band, m), largest, kPanel));
    }
  }
  return drawing;
}

namespace {

constexpr int kMapHeight = 256, kMapWidth = 2 * kMapHeight;
constexpr int kBars = 180;  // height of the plot of energies

/// What is shown of radiance: 1 where the environment itself has its 95th percentile.
Colour shown(const Vec3f& radiance, float white) {
  const Vec3f relative = (radiance / white).cwiseMax(0.0F).cwiseMin(1.0F);
  return relative.unaryExpr([](float v) { return std::pow(v, 1.0F / 2.2F); });
}

Vec3d direction_at(int x, int y) {
  const double up = static_cast<double>(kPi) * (y + 0.5) / kMapHeight;
  const double angle = 2.0 * static_cast<double>(kPi) * ((x + 0.5) / kMapWidth - 0.5);
  return {std::sin(up) * std::sin(angle), std::cos(up), -std::sin(up) * std::cos(angle)};
}

template <typename Radiance>
Drawing draw_map(float white, const Radiance& radiance) {
  Drawing map(kMapWidth, kMapHeight, kSplatBackground);
  for (int y = 0; y < kMapHeight; ++y) {
    for (int x = 0; x < kMapWidth; ++x) map.set(x, y, shown(radiance(direction_at(x, y)), white));
  }
  return map;
}

MatrixD project(const Environment& environment, int order) {
  MatrixD coefficients = MatrixD::Zero(sh_count(order), 3);
  environment.visit(kMapHeight, [&](const Vec3d& d, double weight, const Vec3f& radiance) {
    coefficients += evaluate_sh(order, d) * (weight * radiance.cast<double>()).transpose();
  });
  return coefficients;
}

float white_of(const Environment& environment) {
  std::vector<float> brightest;
  environment.visit(kMapHeight / 4, [&](const Vec3d&, double, const Vec3f& radiance) {
    brightest.push_back(radiance.maxCoeff());
  });
  const auto place = brightest.begin() + static_cast<std::ptrdiff_t>(0.95 * brightest.size());
  std::nth_element(brightest.begin(), place, brightest.end());
  const float largest = *std::ranges::max_element(brightest);
  return *place > 0.0F ? *place : std::max(largest, 1e-30F);
}

/// Share of each band in the energy of all bands, on a logarithmic scale of four decades.
void draw_energies(Drawing& drawing, int left, int top, const VectorD& energy) {
  constexpr double kDecades = 4.0;
  const double total = std::max(energy.sum(), 1e-300);
  const int wide = (2 * kMapWidth + kGap) / static_cast<int>(energy.size());
  for (Eigen::Index l = 0; l < energy.size(); ++l) {
    const double share = energy[l] / total;
    const double height =
        std::clamp(1.0 + std::log10(std::max(share, 1e-300)) / kDecades, 0.0, 1.0);
    const int high = static_cast<int>(height * (kBars - 2 * kName));
    const int x = left + static_cast<int>(l) * wide;
    drawing.fill(x, top + kBars - kName - high, wide - kGap, high, ramp_colour(0.35F));
    drawing.text(x, top + kBars - kName - high - kName, fmt::format("{:.2g}", share), kInk);
    drawing.text(x, top + kBars - kName + 4, fmt::format("band {}", l), kInk);
  }
}

}  // namespace

Drawing draw_environment(const BakeReader& bake, const std::string& spec) {
  require_sky(bake);
  const Environment environment = parse_environment(spec);
  const auto part = bake.artifact(stage_artifact(0));
  const int order = part->attribute<int>("order");
  const MatrixD coefficients = project(environment, order);
  const float white = white_of(environment);
  Drawing drawing(2 * kMapWidth + 3 * kGap, kHead + kMapHeight + 2 * kGap + kBars + kGap,
                  kSplatBackground);
  drawing.text(kGap, 14, "environment", kInk);
  drawing.text(2 * kGap + kMapWidth, 14, fmt::format("its spherical harmonics, order {}", order),
               kInk);
  drawing.paste(kGap, kHead, draw_map(white, [&](const Vec3d& d) {
                  return environment.radiance(d.cast<float>());
                }));
  drawing.paste(2 * kGap + kMapWidth, kHead, draw_map(white, [&](const Vec3d& d) -> Vec3f {
                  return (coefficients.transpose() * evaluate_sh(order, d)).cast<float>();
                }));
  draw_energies(drawing, kGap, kHead + kMapHeight + kGap, band_energy(order, coefficients));
  return drawing;
}

}  // namespace prt
