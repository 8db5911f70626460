#include "transport/free_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/random.h"

namespace prt {
namespace {

/// Tries for one position before we say that there is no free space.
constexpr int kMaxTries = 10'000;
/// Rays to samples before a position counts as unseen: a position that a share f of the samples in
/// front sees is missed with probability (1 - f)^256.
constexpr int kMaxSightRays = 256;
/// Random samples looked at for those rays; about half of them face the position.
constexpr int kMaxSightDraws = 4 * kMaxSightRays;

/// Sides of the box lights are drawn from, at least this share of its diagonal.
constexpr float kLeastSide = 0.1F;
/// A flat, wide scene has little height to keep away in: its shortest side counts this many times.
constexpr float kSideShare = 5.0F;

}  // namespace

LightBox light_box(std::span<const Vec3f> points) {
  LightBox box{Vec3f::Constant(kInfinity), Vec3f::Constant(-kInfinity)};
  for (const Vec3f& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  // A flat scene still has room for lights above it.
  const Vec3f least = Vec3f::Constant(kLeastSide * (box.high - box.low).norm());
  const Vec3f missing = 0.5F * (least - (box.high - box.low)).cwiseMax(0.0F);
  box.low -= missing;
  box.high += missing;
  return box;
}

namespace {

/// The samples are tried in an order drawn from `random`, so that the first few settle most
/// positions.
bool sees_a_sample(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                   const Vec3f& position, Random& random) {
  const auto count = static_cast<std::uint32_t>(samples.size());
  int rays = 0;
  for (int draw = 0; draw < kMaxSightDraws && rays < kMaxSightRays; ++draw) {
    const std::uint32_t s = random.below(count);
    if ((position - samples.positions[s]).dot(samples.normals[s]) <= 0.0F) continue;
    ++rays;
    const Vec3f from = offset_origin(scene, samples.positions[s], samples.normals[s]);
    if (caster.visible(from, position)) return true;
  }
  return false;
}

std::optional<Vec3f> free_position(const Scene& scene, const RayCaster& caster,
                                   const SampleSet& samples, const LightBox& box, float clearance,
                                   Random random) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    const Vec3f p = box.low + (box.high - box.low).cwiseProduct(Vec3f(x, y, z));
    if (caster.closest_distance(p, clearance) < clearance) continue;
    if (sees_a_sample(scene, caster, samples, p, random)) return p;
  }
  return std::nullopt;
}

}  // namespace

std::vector<Vec3f> free_positions(const Scene& scene, const RayCaster& caster,
                                  const SampleSet& samples, float clearance, std::uint64_t stream,
                                  std::size_t first, std::size_t count) {
  const LightBox box = light_box(samples.positions);
  std::vector<Vec3f> positions;
  positions.reserve(count);
  for (std::size_t k = first; k < first + count && samples.size() > 0; ++k) {
    const auto p = free_position(scene, caster, samples, box, clearance, Random(stream, k));
    if (!p) break;
    positions.push_back(*p);
  }
  if (positions.size() < count) {
    throw UserError(fmt::format(
        "no place for a light: in {} tries none inside the samples' bounding box was {:.3g} m away "
        "from every surface and saw one; ask for a smaller clearance or check the scene's scale",
        kMaxTries, clearance));
  }
  return positions;
}

float light_clearance(const SampleSet& samples, float share) {
  const LightBox box = light_box(samples.positions);
  return share * std::min(samples_diagonal(samples), kSideShare * (box.high - box.low).minCoeff());
}

float samples_diagonal(const SampleSet& samples) {
  if (samples.size() == 0) return 0.0F;
  const LightBox box = light_box(samples.positions);
  return (box.high - box.low).norm();
}

}  // namespace prt
