#include "scene/environment.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace prt {
namespace {

constexpr double kPiD = 3.14159265358979323846;

}  // namespace

Environment::Environment(int width, int height, std::vector<Vec3f> radiance)
    : width_(width), height_(height), radiance_(std::move(radiance)) {
  assert(width > 0 && height > 0 &&
         radiance_.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  prepare_sampling();
}

void Environment::prepare_sampling() {
  rows_.reserve(static_cast<std::size_t>(height_));
  columns_.resize(radiance_.size());
  double power = 0.0;
  std::vector<double> sums(static_cast<std::size_t>(width_));
  for (int row = 0; row < height_; ++row) {
    const auto first = static_cast<std::size_t>(row) * sums.size();
    double sum = 0.0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i] = sum += radiance_[first + i].cast<double>().sum();
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      columns_[first + i] = sum > 0.0 ? static_cast<float>(sums[i] / sum) : 1.0F;
    }
    rows_.push_back(power += sum * piece_solid_angle(row, 1));
  }
}

double Environment::piece_solid_angle(int row, int split) const {
  const double step = kPiD / (height_ * split);
  const double band = std::cos(row * step) - std::cos((row + 1) * step);
  return band * 2.0 * kPiD / (width_ * split);
}

/// `up`: cosine of the angle from +Y; `across`: in [0, 1) from the left edge.
Vec3d Environment::from_grid(double up, double across) const {
  const double sine = std::sqrt(std::max(0.0, 1.0 - up * up));
  const double angle = 2.0 * kPiD * (across - 0.5) - turn_;
  return {sine * std::sin(angle), up, -sine * std::cos(angle)};
}

Vec3d Environment::piece_direction(int row, int column, int split) const {
  const double angle = (row + 0.5) * kPiD / (height_ * split);
  return from_grid(std::cos(angle), (column + 0.5) / (width_ * split));
}

Vec3f Environment::radiance(const Vec3f& direction) const {
  const double up = std::clamp<double>(direction.y(), -1.0, 1.0);
  double across = (std::atan2(direction.x(), -direction.z()) + turn_) / (2.0 * kPiD) + 0.5;
  across -= std::floor(across);
  const int row = std::min(height_ - 1, static_cast<int>(std::acos(up) / kPiD * height_));
  const int column = std::min(width_ - 1, static_cast<int>(across * width_));
  return radiance_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(column)];
}

IncidentLight Environment::sample(float u, float v) const {
  const double power = rows_.back();
  if (!(power > 0.0)) return {Vec3f::UnitY(), kInfinity, Vec3f::Zero()};
  const double wanted = v * power;
  const auto row = std::min<std::ptrdiff_t>(
      std::upper_bound(rows_.begin(), rows_.end(), wanted) - rows_.begin(), height_ - 1);
  const double below = row == 0 ? 0.0 : rows_[static_cast<std::size_t>(row) - 1];
  const double of_row = rows_[static_cast<std::size_t>(row)] - below;
  const double down = of_row > 0.0 ? std::clamp((wanted - below) / of_row, 0.0, 1.0) : 0.5;
  const auto begin = columns_.begin() + row * width_;
  const auto column =
      std::min<std::ptrdiff_t>(std::upper_bound(begin, begin + width_, u) - begin, width_ - 1);
  const double left = column == 0 ? 0.0 : *(begin + column - 1);
  const double share = *(begin + column) - left;
  const double along = share > 0.0 ? std::clamp((u - left) / share, 0.0, 1.0) : 0.5;
  const double step = kPiD / height_;
  const double top = std::cos(static_cast<double>(row) * step);
  const double bottom = std::cos(static_cast<double>(row + 1) * step);
  const Vec3d direction =
      from_grid(top + down * (bottom - top), (static_cast<double>(column) + along) / width_);
  const Vec3f& radiance = radiance_[static_cast<std::size_t>(row * width_ + column)];
  const double sum = radiance.cast<double>().sum();
  if (!(sum > 0.0)) return {Vec3f::UnitY(), kInfinity, Vec3f::Zero()};
  return {direction.cast<float>(), kInfinity,
          (radiance.cast<double>() * (power / sum)).cast<float>()};
}

Environment Environment::turned(double degrees) const {
  Environment other = *this;
  other.turn_ += degrees * kPiD / 180.0;
  return other;
}

}  // namespace prt
