#include "apps/inspect/curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/inspect/drawing.h"
#include "store/quantised_io.h"

namespace prt {

namespace {

constexpr double kWidth = 560.0, kHeight = 420.0;  // of a plot's axes
constexpr double kLeft = 80.0, kTop = 50.0, kBottom = 60.0, kRight = 20.0;
constexpr double kStep = kLeft + kWidth + kRight;

struct Axes {
  double low = 0.0, high = 1.0;  ///< decades
  std::size_t most = 2;          ///< values of the longest line

  [[nodiscard]] double x(std::size_t i) const {
    return kLeft + kWidth * static_cast<double>(i) / static_cast<double>(most - 1);
  }
  [[nodiscard]] double y(double decade) const {
    return kTop + kHeight * (high - decade) / (high - low);
  }
};

Axes axes_of(const CurvePlot& plot) {
  constexpr double kDecades = 6.0;  // shown at most below the greatest value
  Axes axes;
  double least = kInfinity, greatest = 0.0;
  for (const auto& line : plot.lines) {
    axes.most = std::max(axes.most, line.size());
    for (const double v : line) {
      if (!(v > 0.0) || !std::isfinite(v)) continue;
      least = std::min(least, v);
      greatest = std::max(greatest, v);
    }
  }
  if (greatest > 0.0) {
    axes.high = std::ceil(std::log10(greatest) + 1e-9);
    axes.low = std::max(axes.high - kDecades, std::floor(std::log10(least)));
    axes.low = std::min(axes.low, axes.high - 1.0);
  }
  return axes;
}

std::string line_svg(const std::vector<double>& line, std::size_t number, const Axes& axes) {
  std::string points;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!(line[i] > 0.0) || !std::isfinite(line[i])) break;
    const double decade = std::max(axes.low, std::log10(line[i]));
    points += fmt::format("{:.1f},{:.1f} ", axes.x(i), axes.y(decade));
  }
  const Colour c = 255.0F * index_colour(static_cast<std::uint32_t>(number));
  return fmt::format(
      "<polyline points=\"{}\" fill=\"none\" stroke=\"rgb({:.0f},{:.0f},{:.0f})\" "
      "stroke-width=\"1.5\"><title>cluster {}</title></polyline>\n",
      points, c.x(), c.y(), c.z(), number);
}

std::string plot_svg(const CurvePlot& plot, double left) {
  const Axes axes = axes_of(plot);
  std::string svg = fmt::format("<g transform=\"translate({},0)\">\n", left);
  svg += fmt::format("<text x=\"{}\" y=\"30\" font-size=\"17\">{}</text>\n", kLeft, plot.title);
  const auto decades = static_cast<int>(std::lround(axes.high - axes.low));
  for (int i = 0; i <= decades; ++i) {
    const double d = axes.low + i;
    svg += fmt::format(
        "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#ddd\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">1e{5:.0f}</text>\n",
        kLeft, kLeft + kWidth, axes.y(d), kLeft - 8.0, axes.y(d) + 5.0, d);
  }
  const std::size_t step = std::max<std::size_t>(1, (axes.most + 7) / 8);
  for (std::size_t i = 0; i < axes.most; i += step) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", axes.x(i),
                       kTop + kHeight + 22.0, i);
  }
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">function</text>\n",
                     kLeft + 0.5 * kWidth, kTop + kHeight + 46.0);
  for (std::size_t c = 0; c < plot.lines.size(); ++c) svg += line_svg(plot.lines[c], c, axes);
  return svg + "</g>\n";
}

/// Calls visit(artifact) for STAGE/0000, STAGE/0001 ... while the bake has them.
template <typename Visit>
void for_clusters(const BakeReader& bake, const std::string& stage, Visit&& visit) {
  std::size_t count = 0;
  for (const ManifestEntry& entry : bake.entries()) {
    if (entry.task.starts_with(stage + "/")) ++count;
  }
  for (std::size_t c = 0; c < count; ++c) {
    const auto artifact = bake.artifact(fmt::format("{}/{:04}", stage, c));
    visit(*artifact);
  }
}

/// Root mean square part that each visibility basis function has in the encoded depths.
std::vector<double> visibility_sizes(const Artifact& visibility) {
  const MatrixF basis = get_quantised(visibility, "basis").decode();
  const MatrixF coefficients = get_quantised(visibility, "coefficients").decode();
  if (coefficients.cols() != basis.rows()) {
    throw UnsoundData("visibility: coefficients and basis do not fit together");
  }
  const double entries =
      static_cast<double>(coefficients.rows()) * static_cast<double>(basis.cols());
  std::vector<double> sizes;
  for (Eigen::Index k = 0; k < basis.rows(); ++k) {
    sizes.push_back(double(coefficients.col(k).norm()) * double(basis.row(k).norm()) /
                    std::sqrt(std::max(1.0, entries)));
  }
  return sizes;
}

}  // namespace

std::string curves_svg(const std::vector<CurvePlot>& plots) {
  const double width = kStep * static_cast<double>(plots.size()) + kRight;
  const double height = kTop + kHeight + kBottom;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"sans-serif\" font-size=\"13\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      width, height);
  for (std::size_t i = 0; i < plots.size(); ++i) svg += plot_svg(plots[i], kStep * double(i));
  return svg + "</svg>\n";
}

std::string draw_curves(const BakeReader& bake) {
  CurvePlot lights{"effect that hangs on each light function, W/m", {}};
  CurvePlot depths{"rms part of each visibility function in z", {}};
  for_clusters(bake, "light_basis", [&](const Artifact& a) {
    const auto strengths = a.values<float>("strengths");
    lights.lines.emplace_back(strengths.begin(), strengths.end());
  });
  for_clusters(bake, "visibility",
               [&](const Artifact& a) { depths.lines.push_back(visibility_sizes(a)); });
  std::vector<CurvePlot> plots;
  for (CurvePlot& plot : {std::ref(lights), std::ref(depths)}) {
    if (!plot.lines.empty()) plots.push_back(std::move(plot));
  }
  if (plots.empty()) throw UserError(bake.path().string() + ": no basis is finished in this bake");
  return curves_svg(plots);
}

}  // namespace prt
