#include "apps/inspect/basis_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/inspect/splat_canvas.h"
#include "store/samples_io.h"

namespace prt {

namespace {

constexpr int kFunctionPanel = 220;  // pixels; a function alone gets four times as many each way
constexpr int kFunctionMargin = 12;
constexpr int kFunctionTitle = 44;
constexpr int kLabel = 20;
const Colour kBehind(0.8F, 0.8F, 0.8F);  // white is zero, and has to show
constexpr float kFarView = 0.02F;        // tangent of half the field of view: nearly parallel

/// Light functions of one cluster: values(s, k) of function k at its sample s.
struct Functions {
  SampleSet samples;
  std::uint32_t begin = 0, end = 0;
  MatrixF values;
};

Functions read_functions(const BakeReader& bake, int cluster) {
  Functions f;
  f.samples = get_samples(*bake.artifact("samples"));
  const auto c = static_cast<std::size_t>(cluster);
  if (c >= f.samples.clusters()) {
    throw UserError(fmt::format("--cluster {}: the bake has {} clusters, from 0 on", cluster,
                                f.samples.clusters()));
  }
  f.begin = f.samples.cluster_begin[c];
  f.end = f.samples.cluster_begin[c + 1];
  const auto artifact = bake.artifact("light_functions");
  const auto first = artifact->values<std::uint32_t>("begin");
  const MatrixF all = artifact->matrix("values");
  const bool fits = first.size() == f.samples.clusters() + 1 && first[c] <= first[c + 1] &&
                    all.rows() == static_cast<Eigen::Index>(f.samples.size()) &&
                    all.cols() >= static_cast<Eigen::Index>(first[c + 1] - first[c]);
  if (!fits) throw UnsoundData("light_functions does not fit samples");
  f.values = all.block(f.begin, 0, f.end - f.begin, first[c + 1] - first[c]);
  return f;
}

Vec3f mean_normal(const Functions& f) {
  Vec3f sum = Vec3f::Zero();
  for (std::uint32_t s = f.begin; s < f.end; ++s) {
    sum += f.samples.radii[s] * f.samples.radii[s] * f.samples.normals[s];
  }
  return sum.norm() > 0.0F ? Vec3f(sum.normalized()) : Vec3f::UnitY();
}

Drawing draw_function(const Functions& f, Eigen::Index k, int size) {
  const int fine = size * kSplatSupersampling;
  const SplatCamera camera =
      make_splat_camera(f.samples, f.begin, f.end, mean_normal(f), kFarView, fine, fine);
  const float largest = f.values.col(k).cwiseAbs().maxCoeff();
  SplatCanvas canvas(fine, fine, kBehind);
  for (std::uint32_t s = f.begin; s < f.end; ++s) {
    const float value = largest > 0.0F ? f.values(s - f.begin, k) / largest : 0.0F;
    canvas.splat(camera, f.samples.positions[s], f.samples.normals[s], f.samples.radii[s],
                 difference_colour(value));
  }
  return canvas.drawing();
}

}  // namespace

Drawing draw_basis(const BakeReader& bake, int cluster, std::optional<int> index) {
  const Functions f = read_functions(bake, cluster);
  const auto count = static_cast<int>(f.values.cols());
  if (index && *index >= count) {
    throw UserError(fmt::format("--index {}: cluster {} has {} light functions, from 0 on", *index,
                                cluster, count));
  }
  const int first = index.value_or(0);
  const int shown = index ? 1 : count;
  const int size = index ? 4 * kFunctionPanel : kFunctionPanel;
  const int columns = std::max(3, static_cast<int>(std::ceil(std::sqrt(1.4 * shown))));
  const int across = index ? 1 : columns;
  const int rows = (shown + across - 1) / across;
  Drawing drawing(across * (size + kFunctionMargin) + kFunctionMargin,
                  kFunctionTitle + rows * (size + kLabel + kFunctionMargin) + kFunctionMargin,
                  kSplatBackground);
  drawing.text(
      kFunctionMargin, 16,
      fmt::format("cluster {}: {} samples, {} light functions", cluster, f.end - f.begin, count),
      kInk);
  for (int i = 0; i < shown; ++i) {
    const int left = kFunctionMargin + i % across * (size + kFunctionMargin);
    const int top = kFunctionTitle + i / across * (size + kLabel + kFunctionMargin);
    const int k = first + i;
    drawing.text(left, top, fmt::format("{}", k), kInk);
    drawing.paste(left, top + kLabel, draw_function(f, k, size));
  }
  return drawing;
}

}  // namespace prt
