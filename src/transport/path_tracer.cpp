#include "transport/path_tracer.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace prt {
namespace {

/// Points traced as one wave: enough rays for full packets, few enough for the caches.
constexpr std::size_t kWavePoints = 32;
/// Vertices before Russian roulette may end a path.
constexpr int kFirstRouletteBounce = 4;
/// A path survives with at most this probability, so that white scenes end too.
constexpr float kMaxSurvival = 0.98F;

/// Radical inverse in base 2 with a digital shift: with i/n it forms a (0,m,2)-net, and each value
/// is uniform in [0, 1) over random shifts (Kollig & Keller 2002).
float shifted_radical_inverse(std::uint32_t i, std::uint32_t shift) {
  std::uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= ((i >> bit) & 1U) << (31 - bit);
  return static_cast<float>((reversed ^ shift) >> 8) * 0x1p-24F;
}

/// `i` of `n` stratified points in [0, 1)²; random numbers from the item's own sequence.
Vec2f net_point(std::uint32_t i, std::uint32_t n, std::uint32_t shift, Random& random) {
  const float u = (static_cast<float>(i) + random.uniform()) / static_cast<float>(n);
  return {std::min(u, 1.0F - 0x1p-24F), shifted_radical_inverse(i, shift)};
}

struct Path {
  Random random;
  Vec3f throughput = Vec3f::Ones();  ///< product of the albedos so far, over survival probabilities
  std::uint32_t sum = 0;             ///< 2 · point + half
};

/// Shadow rays waiting to be cast, each with what it brings if nothing is in its way.
class ShadowQueue {
 public:
  /// Adds irradiance · weight at the surface point to `sum` unless a light sample is hidden. The
  /// ray starts at the light, where neighbouring rays are coherent.
  void add(const Scene& scene, const IncidentLight& incident, const Vec3f& position,
           const Vec3f& normal, const Vec3f& weight, std::uint32_t sum) {
    const float cosine = normal.dot(incident.to_light);
    if (!(cosine > 0.0F) || incident.irradiance.isZero(0.0F)) return;
    const Vec3f end = offset_origin(scene, position, normal);
    if (std::isinf(incident.distance)) {
      rays_.push_back({end, incident.to_light});
    } else {
      const Vec3f start = position + incident.distance * incident.to_light;
      const Vec3f way = end - start;
      const float length = way.norm();
      rays_.push_back({start, way / length, 0.0F, length});
    }
    brings_.push_back({weight.cwiseProduct(cosine * incident.irradiance), sum});
  }

  /// Casts all rays, adds what arrives, in order of addition, and empties the queue.
  void cast(const RayCaster& caster, std::vector<Vec3d>& sums) {
    blocked_.resize(rays_.size());
    caster.occluded(rays_, blocked_);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (!blocked_[i]) sums[brings_[i].sum] += brings_[i].irradiance.cast<double>();
    }
    rays_.clear();
    brings_.clear();
  }

 private:
  struct Bring {
    Vec3f irradiance;
    std::uint32_t sum;
  };
  std::vector<Ray> rays_;
  std::vector<Bring> brings_;
  std::vector<std::uint8_t> blocked_;
};

/// One wave: all paths of a few points, bounce by bounce.
class Wave {
 public:
  Wave(const Scene& scene, const RayCaster& caster, std::span<const Light> lights,
       const PathTracerSettings& settings, std::uint64_t stream)
      : scene_(scene),
        caster_(caster),
        lights_(lights),
        paths_per_half_(static_cast<std::uint32_t>(std::max(1, (settings.paths + 1) / 2))),
        bounces_(settings.bounces),
        environment_(settings.environment),
        shift_stream_(stream_key(stream, "path tracer shift")),
        path_stream_(stream_key(stream, "path tracer path")),
        area_stream_(stream_key(stream, "path tracer area light")) {}

  void trace(std::span<const ReceiverPoint> points, std::uint64_t first_item,
             std::span<IrradianceEstimate> out) {
    trace_direct(points, first_item);
    store(out, &IrradianceEstimate::direct);
    sums_.assign(2 * points.size(), Vec3d::Zero());
    start_paths(points, first_item);
    for (int bounce = 1; !paths_.empty() && (bounces_ < 0 || bounce <= bounces_); ++bounce) {
      hits_.resize(rays_.size());
      if (bounce == 1)
        caster_.intersect_coherent(rays_, hits_);
      else
        caster_.intersect_incoherent(rays_, hits_);
      reflect(bounce);
      shadows_.cast(caster_, sums_);
    }
    for (Vec3d& sum : sums_) sum /= paths_per_half_;
    store(out, &IrradianceEstimate::indirect);
  }

 private:
  void trace_direct(std::span<const ReceiverPoint> points, std::uint64_t first_item) {
    sums_.assign(2 * points.size(), Vec3d::Zero());
    for (std::size_t p = 0; p < points.size(); ++p) {
      for (std::size_t l = 0; l < lights_.size(); ++l) {
        if (is_punctual(lights_[l])) {
          shadows_.add(scene_, incident_light(lights_[l], points[p].position, 0.5F, 0.5F),
                       points[p].position, points[p].normal, Vec3f::Ones(),
                       static_cast<std::uint32_t>(2 * p));
        }
      }
    }
    shadows_.cast(caster_, sums_);
    for (std::size_t p = 0; p < points.size(); ++p) sums_[2 * p + 1] = sums_[2 * p];
    for (std::size_t p = 0; p < points.size(); ++p) {
      for (std::size_t l = 0; l < lights_.size(); ++l) {
        if (is_punctual(lights_[l])) continue;
        sample_area(l, points[p], first_item + p, p, [&](float u, float v) {
          return incident_light(lights_[l], points[p].position, u, v);
        });
      }
      if (environment_ == nullptr) continue;
      sample_area(lights_.size(), points[p], first_item + p, p,
                  [&](float u, float v) { return environment_->sample(u, v); });
    }
    shadows_.cast(caster_, sums_);
  }

  /// `sample(u, v)`: the light's; `number` of the light.
  template <typename Sample>
  void sample_area(std::size_t number, const ReceiverPoint& point, std::uint64_t item,
                   std::size_t p, const Sample& sample) {
    const Vec3f weight = Vec3f::Constant(1.0F / static_cast<float>(paths_per_half_));
    for (std::uint32_t half = 0; half < 2; ++half) {
      Random random(area_stream_ + 2 * number + half, item);
      const std::uint32_t shift = random.bits();
      for (std::uint32_t i = 0; i < paths_per_half_; ++i) {
        const Vec2f uv = net_point(i, paths_per_half_, shift, random);
        shadows_.add(scene_, sample(uv.x(), uv.y()), point.position, point.normal, weight,
                     static_cast<std::uint32_t>(2 * p + half));
      }
    }
  }

  void start_paths(std::span<const ReceiverPoint> points, std::uint64_t first_item) {
    paths_.clear();
    rays_.clear();
    for (std::size_t p = 0; p < points.size() && bounces_ != 0; ++p) {
      const Vec3f origin = offset_origin(scene_, points[p].position, points[p].normal);
      for (std::uint32_t half = 0; half < 2; ++half) {
        const std::uint64_t item = 2 * (first_item + p) + half;
        const std::uint32_t shift = Random(shift_stream_, item).bits();
        for (std::uint32_t i = 0; i < paths_per_half_; ++i) {
          Random random(path_stream_, (item << 20) + i);
          const Vec2f uv = net_point(i, paths_per_half_, shift, random);
          rays_.push_back({origin, cosine_direction(points[p].normal, uv.x(), uv.y())});
          paths_.push_back({random, Vec3f::Ones(), static_cast<std::uint32_t>(2 * p + half)});
        }
      }
    }
  }

  /// Takes the direct light at each hit and sends the surviving paths on. Cosine-distributed
  /// directions make every estimate of irradiance π·L, so a vertex brings throughput · albedo · its
  /// irradiance.
  void reflect(int bounce) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      if (hits_[i].escaped()) continue;
      Path& path = paths_[i];
      const SurfacePoint at = surface_at(scene_, rays_[i], hits_[i]);
      const Vec3f albedo = albedo_at(scene_, at.triangle, at.u, at.v);
      path.throughput = path.throughput.cwiseProduct(albedo);
      if (path.throughput.isZero(0.0F)) continue;
      for (const Light& light : lights_) {
        const float u = is_punctual(light) ? 0.5F : path.random.uniform();
        const float v = is_punctual(light) ? 0.5F : path.random.uniform();
        shadows_.add(scene_, incident_light(light, at.position, u, v), at.position, at.normal,
                     path.throughput, path.sum);
      }
      if (environment_ != nullptr) {
        const float u = path.random.uniform(), v = path.random.uniform();
        shadows_.add(scene_, environment_->sample(u, v), at.position, at.normal, path.throughput,
                     path.sum);
      }
      if (!survives(path, albedo, bounce)) continue;
      const float u = path.random.uniform(), v = path.random.uniform();
      const Ray next{offset_origin(scene_, at.position, at.normal),
                     cosine_direction(at.normal, u, v)};
      rays_[kept] = next;
      paths_[kept++] = path;
    }
    const auto end = static_cast<std::ptrdiff_t>(kept);
    rays_.erase(rays_.begin() + end, rays_.end());
    paths_.erase(paths_.begin() + end, paths_.end());
  }

  /// Russian roulette: the expected throughput is unchanged.
  static bool survives(Path& path, const Vec3f& albedo, int bounce) {
    if (bounce < kFirstRouletteBounce) return true;
    const float chance = std::min(albedo.maxCoeff(), kMaxSurvival);
    if (path.random.uniform() >= chance) return false;
    path.throughput /= chance;
    return true;
  }

  void store(std::span<IrradianceEstimate> out,
             std::array<Vec3f, 2> IrradianceEstimate::*part) const {
    for (std::size_t p = 0; p < out.size(); ++p) {
      for (std::size_t half = 0; half < 2; ++half) {
        (out[p].*part)[half] = sums_[2 * p + half].cast<float>();
      }
    }
  }

  const Scene& scene_;
  const RayCaster& caster_;
  std::span<const Light> lights_;
  std::uint32_t paths_per_half_;
  int bounces_;
  const Environment* environment_;
  std::uint64_t shift_stream_, path_stream_, area_stream_;
  std::vector<Path> paths_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<Vec3d> sums_;  ///< two halves per point
  ShadowQueue shadows_;
};

}  // namespace

std::vector<IrradianceEstimate> trace_irradiance(const Scene& scene, const RayCaster& caster,
                                                 std::span<const Light> lights,
                                                 std::span<const ReceiverPoint> points,
                                                 const PathTracerSettings& settings,
                                                 std::uint64_t stream, std::uint64_t first_item) {
  std::vector<IrradianceEstimate> estimates(points.size());
  Wave wave(scene, caster, lights, settings, stream);
  for (std::size_t begin = 0; begin < points.size(); begin += kWavePoints) {
    const std::size_t size = std::min(kWavePoints, points.size() - begin);
    wave.trace(points.subspan(begin, size), first_item + begin,
               std::span(estimates).subspan(begin, size));
  }
  return estimates;
}

}  // namespace prt
