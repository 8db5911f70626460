// Environment specifications of the command line.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "scene/environment.h"
#include "scene/radiance_image.h"
#include "scene/spec_fields.h"

namespace prt {
namespace {

/// Cells of tables made from formulas: an error of the midpoint rule of some 1e-6.
constexpr int kRows = 512;
constexpr int kDiscRows = 1024;  ///< a disc may be small
/// A probe's rim is finer than any table; its middle is what counts.
constexpr int kMostProbeRows = 2048;

enum Form : std::size_t { kSky, kGradient, kLobes, kDisc, kMap, kProbe };

const std::vector<SpecForm>& forms() {
  static const std::vector<SpecForm> all = {
      {"sky", "sky:r,g,b", {3}},           {"gradient", "gradient:r,g,b:r,g,b:r,g,b", {3, 3, 3}},
      {"lobes", "lobes:r,g,b", {3}},       {"disc", "disc:dx,dy,dz:r,g,b:radius_deg", {3, 3, 1}},
      {"map", "map:FILE.hdr or .exr", {}}, {"probe", "probe:FILE.hdr or .exr", {}},
  };
  return all;
}

/// A table of f, taken in the middle of `pieces`² parts of each cell.
template <typename F>
Environment table(int rows, int pieces, const F& f) {
  const Environment grid(2 * rows, rows, std::vector<Vec3f>(2UL * rows * rows, Vec3f::Zero()));
  std::vector<Vec3f> radiance(2UL * rows * rows, Vec3f::Zero());
  std::size_t piece = 0;
  const auto across =
      std::size_t{2} * static_cast<std::size_t>(rows) * static_cast<std::size_t>(pieces);
  const float share = 1.0F / static_cast<float>(pieces * pieces);
  grid.visit(rows * pieces, [&](const Vec3d& direction, double, const Vec3f&) {
    const std::size_t row = piece / across / static_cast<std::size_t>(pieces);
    const std::size_t column = piece % across / static_cast<std::size_t>(pieces);
    radiance[row * 2UL * rows + column] += share * f(direction);
    ++piece;
  });
  return {2 * rows, rows, std::move(radiance)};
}

/// SH §6.2.4, after Green: two monochromatic lights at a right angle.
double tutorial_lobes(const Vec3d& d) {
  // Its θ is counted from straight up and φ from +Z towards +X.
  const double phi = std::atan2(d.x(), d.z());
  const double sine = std::sqrt(std::max(0.0, 1.0 - d.y() * d.y()));
  return std::max(0.0, 5.0 * d.y() - 4.0) + std::max(0.0, 4.0 * sine * std::cos(phi - 2.5) - 3.0);
}

Environment make_gradient(const SpecFields& spec) {
  const Vec3f up = spec.colour(0), horizon = spec.colour(1), down = spec.colour(2);
  return table(kRows, 1, [&](const Vec3d& d) -> Vec3f {
    const auto share = static_cast<float>(std::abs(d.y()));
    return (1.0F - share) * horizon + share * (d.y() > 0.0 ? up : down);
  });
}

Environment make_disc(const SpecFields& spec) {
  const Vec3d to_sun = -spec.unit_direction(0).cast<double>();
  const Vec3f radiance = spec.colour(1);
  const double radius = spec.number(2);
  if (!(radius >= 0.1 && radius <= 90.0)) spec.fail("the radius must be 0.1 to 90 degrees");
  // Cosines near 1 say little of small angles; half the chord does. A cell on the edge has the
  // share of the disc that lies in it, about.
  const double chord = 2.0 * std::sin(0.5 * radius * static_cast<double>(kPi) / 180.0);
  const double cell = static_cast<double>(kPi) / kDiscRows;
  return table(kDiscRows, 1, [&](const Vec3d& d) -> Vec3f {
    const double within = 0.5 + (chord - (d - to_sun).norm()) / cell;
    return static_cast<float>(std::clamp(within, 0.0, 1.0)) * radiance;
  });
}

Environment from_map(const std::filesystem::path& file) {
  RadianceImage image = read_radiance_image(file);
  if (image.width != 2 * image.height) {
    throw UserError(fmt::format(
        "{}: {} x {} pixels are no equirectangular map: it should be twice as wide as high (a "
        "square light probe is given as probe:FILE)",
        file.string(), image.width, image.height));
  }
  return {image.width, image.height, std::move(image.pixels)};
}

/// SH §6.2.4: the angle from +Z grows in proportion to the distance from the middle; up is +Y.
Environment from_probe(const std::filesystem::path& file) {
  const RadianceImage image = read_radiance_image(file);
  if (image.width != image.height) {
    throw UserError(fmt::format(
        "{}: {} x {} pixels are no light probe: it should be square (an equirectangular "
        "map is given as map:FILE)",
        file.string(), image.width, image.height));
  }
  const auto pixel = [&](double t) {
    return std::clamp(static_cast<int>(t * image.width), 0, image.width - 1);
  };
  return table(std::clamp(image.height, 128, kMostProbeRows), 2, [&](const Vec3d& d) -> Vec3f {
    const double off_axis = std::hypot(d.x(), d.y());
    const double angle = std::atan2(off_axis, d.z());
    const double r = off_axis > 0.0 ? angle / (2.0 * static_cast<double>(kPi) * off_axis) : 0.0;
    return image.pixels[static_cast<std::size_t>(pixel(0.5 - r * d.y())) *
                            static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(pixel(0.5 + r * d.x()))];
  });
}

}  // namespace

Environment parse_environment(std::string_view text) {
  const bool is_form = std::ranges::any_of(
      forms(), [&](const SpecForm& form) { return text.substr(0, text.find(':')) == form.name; });
  if (!is_form && (text.ends_with(".hdr") || text.ends_with(".exr"))) return from_map(text);
  const SpecFields spec("environment", text, forms());
  switch (spec.form()) {
    case kSky:
      return {2, 1, std::vector<Vec3f>(2, spec.colour(0))};
    case kGradient:
      return make_gradient(spec);
    case kLobes: {
      const Vec3f scale = spec.colour(0);
      return table(kRows, 1, [&](const Vec3d& d) -> Vec3f {
        return static_cast<float>(tutorial_lobes(d)) * scale;
      });
    }
    case kDisc:
      return make_disc(spec);
    case kMap:
      return from_map(spec.rest());
    default:
      return from_probe(spec.rest());
  }
}

}  // namespace prt
