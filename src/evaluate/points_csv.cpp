#include "evaluate/points_csv.h"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "base/atomic_file.h"
#include "base/error.h"

namespace prt {
namespace {

constexpr std::string_view kHeader = "x,y,z,nx,ny,nz";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Finite as a float, too.
std::optional<double> finite_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  if (!std::isfinite(static_cast<float>(value))) return {};
  return value;
}

/// Why a line is no point, or nothing.
std::optional<std::string> parse_point(std::string_view line, WorldPoint& point) {
  std::array<double, 6> values{};
  std::size_t column = 0;
  for (bool more = true; more; ++column) {
    const auto comma = line.find(',');
    more = comma != std::string_view::npos;
    const std::string_view cell = trimmed(line.substr(0, comma));
    if (column < values.size()) {
      const auto value = finite_number(cell);
      if (!value) return fmt::format("'{}' in column {} is not a finite number", cell, column + 1);
      values[column] = *value;
    }
    if (more) line.remove_prefix(comma + 1);
  }
  if (column != values.size()) return fmt::format("{} columns instead of 6 ({})", column, kHeader);
  const Vec3d normal(values[3], values[4], values[5]);
  if (!(normal.norm() > 0.0)) return std::string("the normal is zero");
  point = {Vec3d(values[0], values[1], values[2]), normal.normalized().cast<float>()};
  return std::nullopt;
}

}  // namespace

std::vector<WorldPoint> read_points_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw UserError(fmt::format("{}: cannot be read; is the path right?", file.string()));
  std::string line;
  if (!std::getline(in, line) || trimmed(line) != kHeader) {
    throw UserError(fmt::format("{}:1: the first line must be '{}'", file.string(), kHeader));
  }
  std::vector<WorldPoint> points;
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (trimmed(line).empty()) continue;
    WorldPoint point;
    if (const auto wrong = parse_point(line, point)) {
      throw UserError(fmt::format("{}:{}: {}", file.string(), number, *wrong));
    }
    points.push_back(point);
  }
  if (in.bad()) throw UserError(fmt::format("{}: reading failed", file.string()));
  if (points.empty()) {
    throw UserError(
        fmt::format("{}: holds no points; give one per line after the header", file.string()));
  }
  return points;
}

std::vector<ReceiverPoint> points_in(const Vec3d& origin, std::span<const WorldPoint> points) {
  std::vector<ReceiverPoint> placed;
  placed.reserve(points.size());
  for (const WorldPoint& p : points) placed.push_back({relative_to(origin, p.position), p.normal});
  return placed;
}

void write_points_csv(const std::filesystem::path& file, std::span<const WorldPoint> points,
                      std::span<const PointIrradiance> values) {
  assert(points.size() == values.size());
  std::string text =
      fmt::format("{},direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b\n", kHeader);
  const auto cell = [](float v) {
    return std::isnan(v) ? std::string("nan") : fmt::format("{:.9g}", v);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& p = points[i].position;
    text += fmt::format("{},{},{}", p.x(), p.y(), p.z());
    for (const Vec3f& triple : {points[i].normal, values[i].direct, values[i].indirect}) {
      for (int c = 0; c < 3; ++c) text += "," + cell(triple[c]);
    }
    text += '\n';
  }
  write_file_atomically(file, std::as_bytes(std::span(text)));
}

}  // namespace prt
