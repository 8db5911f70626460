#include "player/tone.h"

#include <algorithm>
#include <cmath>

namespace prt {
namespace {

constexpr double kPercentile = 0.9;
constexpr float kBright = 0.6F;

}  // namespace

float own_exposure(std::span<const Vec3f> radiance) {
  const Vec3f rec709(0.2126F, 0.7152F, 0.0722F);
  std::vector<float> luminance;
  for (const Vec3f& r : radiance) {
    const float l = rec709.dot(r);
    if (l > 0.0F && std::isfinite(l)) luminance.push_back(l);
  }
  if (luminance.empty()) return 1.0F;
  const auto at = luminance.begin() + static_cast<std::ptrdiff_t>(
                                          kPercentile * static_cast<double>(luminance.size() - 1));
  std::nth_element(luminance.begin(), at, luminance.end());
  return kBright / *at;
}

Vec3f filmic(const Vec3f& exposed) {
  const Eigen::Array3f x = exposed.array().max(0.0F).min(1e4F);
  return ((x * (2.51F * x + 0.03F)) / (x * (2.43F * x + 0.59F) + 0.14F)).max(0.0F).min(1.0F);
}

std::uint8_t srgb_byte(float linear) {
  const float value =
      linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F)));
}

}  // namespace prt
