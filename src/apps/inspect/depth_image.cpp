#include "apps/inspect/depth_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bases/depth_basis.h"
#include "domains/directions.h"
#include "store/quantised_io.h"

namespace prt {

namespace {

constexpr int kPanel = 320;  // pixels of a disk's diameter
constexpr int kMargin = 24;
constexpr int kTitle = 56;
constexpr int kScaleHeight = 90;
const Colour kPaper = Colour::Ones();

/// One sample's encoded depths (z = √(t / bound), by direction).
struct Depths {
  VectorF cast;
  VectorF reconstructed;
  float bound = 0.0F;
  std::size_t rank = 0;
};

Depths read_depths(const BakeReader& bake, int cluster, int index) {
  const std::string number = fmt::format("{:04}", cluster);
  const auto rays = bake.artifact("rays/" + number);
  const auto visibility = bake.artifact("visibility/" + number);
  if (visibility->has("walls")) {
    throw UserError(fmt::format(
        "--cluster {}: it sees everything up to its walls and has no depth basis; take another",
        cluster));
  }
  const auto packed = rays->values<std::uint16_t>("distance");
  const auto& dims = rays->at("distance").dims;
  if (dims.size() != 2) throw UnsoundData("rays/" + number + ": distance is not a matrix");
  const auto samples = static_cast<std::size_t>(dims[0]);
  const auto directions = static_cast<std::size_t>(dims[1]);
  if (static_cast<std::size_t>(index) >= samples) {
    throw UserError(
        fmt::format("--index {}: cluster {} has {} samples, from 0 on", index, cluster, samples));
  }
  const MatrixF mean = get_quantised(*visibility, "mean").decode();
  const MatrixF basis = get_quantised(*visibility, "basis").decode();
  const MatrixF coefficients = get_quantised(*visibility, "coefficients").decode();
  if (mean.size() != static_cast<Eigen::Index>(directions) || basis.cols() != mean.size() ||
      coefficients.cols() != basis.rows() ||
      coefficients.rows() != static_cast<Eigen::Index>(samples)) {
    throw UnsoundData("visibility/" + number + " does not fit rays/" + number);
  }
  Depths depths;
  depths.bound = rays->attribute<float>("bound");
  depths.rank = static_cast<std::size_t>(basis.rows());
  depths.cast.resize(mean.size());
  for (std::size_t d = 0; d < directions; ++d) {
    depths.cast[static_cast<Eigen::Index>(d)] = unpack_depth(packed[index * directions + d]);
  }
  depths.reconstructed = (coefficients.row(index) * basis + mean.row(0)).transpose();
  return depths;
}

/// Draws a function of direction twice: unfolded, and as an equal-area disk about the normal.
template <typename ColourOf>
void draw_panel(Drawing& picture, int left, const HemisphereDirections& directions,
                const ColourOf& colour_of) {
  for (int y = 0; y < kPanel; ++y) {
    for (int x = 0; x < kPanel; ++x) {
      const int column = x * directions.width() / kPanel;
      const int row = y * directions.height() / kPanel;
      picture.set(left + x, kTitle + y, colour_of(row * directions.width() + column));
      const Vec2f disk((2.0F * static_cast<float>(x) + 1.0F) / kPanel - 1.0F,
                       (2.0F * static_cast<float>(y) + 1.0F) / kPanel - 1.0F);
      const float r2 = disk.squaredNorm();
      if (r2 >= 1.0F) continue;
      const float stretch = std::sqrt(2.0F - r2);
      const auto four = directions.lookup(Vec3f(disk.x() * stretch, disk.y() * stretch, 1.0F - r2));
      const auto nearest = std::ranges::max_element(four.weight) - four.weight.begin();
      picture.set(left + x, kTitle + kPanel + kMargin + y, colour_of(four.index[nearest]));
    }
  }
}

/// A bar from t = 0 to 1 with labels under its ends and middle.
template <typename ColourOf>
void draw_scale(Drawing& picture, int left, int width, const ColourOf& colour_of,
                const std::array<std::string, 3>& labels) {
  const int top = kTitle + 2 * (kPanel + kMargin);
  for (int x = 0; x < width; ++x) {
    picture.fill(left + x, top, 1, 18,
                 colour_of((static_cast<float>(x) + 0.5F) / static_cast<float>(width)));
  }
  constexpr int kLetter = 12;  // pixels, about
  const auto place = [&](int i) {
    const int length = kLetter * static_cast<int>(labels[i].size());
    return left + i * (width - length) / 2;
  };
  for (int i = 0; i < 3; ++i) picture.text(place(i), top + 26, labels[i], kInk);
}

}  // namespace

Drawing draw_depth(const BakeReader& bake, int cluster, int index) {
  const Depths depths = read_depths(bake, cluster, index);
  const HemisphereDirections directions(static_cast<int>(depths.cast.size()));
  const VectorF difference = depths.reconstructed - depths.cast;
  const float largest = std::max(difference.cwiseAbs().maxCoeff(), 1e-6F);
  const double rms =
      std::sqrt(difference.cast<double>().squaredNorm() / static_cast<double>(difference.size()));
  const int step = kPanel + kMargin;
  Drawing picture(3 * step + kMargin, kTitle + 2 * step + kScaleHeight, kPaper);
  const auto title = [&](int panel, const std::string& text) {
    picture.text(kMargin + panel * step, 18, text, kInk);
  };
  title(0, fmt::format("cast: cluster {}, sample {}", cluster, index));
  title(1, fmt::format("from {} basis functions", depths.rank));
  title(2, fmt::format("difference, rms {:.3f}", rms));
  draw_panel(picture, kMargin, directions, [&](int i) { return ramp_colour(depths.cast[i]); });
  draw_panel(picture, kMargin + step, directions,
             [&](int i) { return ramp_colour(depths.reconstructed[i]); });
  draw_panel(picture, kMargin + 2 * step, directions,
             [&](int i) { return difference_colour(difference[i] / largest); });
  // The scale is even in z = √(t / bound): its middle is a quarter of the bound.
  draw_scale(picture, kMargin, 2 * kPanel + kMargin, ramp_colour,
             {"0 m", fmt::format("{:.2f} m", 0.25F * depths.bound),
              fmt::format("{:.2f} m or escaped", depths.bound)});
  draw_scale(picture, kMargin + 2 * step, kPanel,
             [](float t) { return difference_colour(2.0F * t - 1.0F); },
             {fmt::format("-{:.2f}", largest), "0", fmt::format("{:.2f} of z", largest)});
  return picture;
}

}  // namespace prt
