#include "player/light_samples.h"

#include <algorithm>
#include <cmath>

namespace prt {
namespace {

/// Van der Corput's radical inverse in base 2.
float radical_inverse(std::uint32_t i) {
  float value = 0.0F;
  for (float digit = 0.5F; i != 0; i >>= 1, digit *= 0.5F) {
    if ((i & 1U) != 0) value += digit;
  }
  return value;
}

}  // namespace

void light_samples(const Light& light, int count, std::vector<Vec2f>& samples) {
  samples.clear();
  if (is_punctual(light) || count <= 1) {
    samples.emplace_back(0.5F, 0.5F);
    return;
  }
  const int side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(count))));
  for (int i = 0; i < count; ++i) {
    if (side * side == count) {
      samples.emplace_back((static_cast<float>(i / side) + 0.5F) / static_cast<float>(side),
                           (static_cast<float>(i % side) + 0.5F) / static_cast<float>(side));
    } else {
      samples.emplace_back((static_cast<float>(i) + 0.5F) / static_cast<float>(count),
                           radical_inverse(static_cast<std::uint32_t>(i)));
    }
  }
}

std::vector<Vec2f> light_samples(const Light& light, int count) {
  std::vector<Vec2f> samples;
  light_samples(light, count, samples);
  return samples;
}

Vec3f unshadowed_irradiance(const Light& light, std::span<const Vec2f> samples, const Vec3f& p,
                            const Vec3f& n) {
  Vec3f sum = Vec3f::Zero();
  for (const Vec2f& uv : samples) {
    const IncidentLight incident = incident_light(light, p, uv.x(), uv.y());
    sum += std::max(0.0F, n.dot(incident.to_light)) * incident.irradiance;
  }
  return sum / static_cast<float>(samples.size());
}

}  // namespace prt
