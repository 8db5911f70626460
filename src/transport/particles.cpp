#include "transport/particles.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/random.h"
#include "transport/area_points.h"

namespace prt {

void SurfacePoints::append(const SurfacePoints& other) {
  positions.insert(positions.end(), other.positions.begin(), other.positions.end());
  normals.insert(normals.end(), other.normals.begin(), other.normals.end());
  triangles.insert(triangles.end(), other.triangles.begin(), other.triangles.end());
}

namespace {

constexpr std::size_t kBatch = 1024;

struct Particle {
  Random random;
  int collisions = 0;
};

/// Advances all particles of a batch by one collision; drops those that escape or have ended.
struct Batch {
  std::vector<Particle> particles;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
};

void start_batch(Batch& batch, const ParticleSettings& s, std::uint64_t first) {
  batch.particles.clear();
  batch.rays.clear();
  for (std::size_t i = 0; i < kBatch; ++i) {
    Random random(s.stream, first + i);
    const float u = random.uniform();
    const float v = random.uniform();
    batch.rays.push_back({s.start, sphere_direction(u, v)});
    batch.particles.push_back({random, 0});
  }
}

/// Where a particle leaves a surface that it met along `ray`: a little back on its way, which is
/// known to be free. A step along the normal may cross a second surface in an acute corner.
Vec3f step_back(const Scene& scene, const Ray& ray, const Hit& hit, const SurfacePoint& at) {
  const float height = (offset_origin(scene, at.position, at.normal) - at.position).norm();
  const float slope = std::abs(ray.direction.dot(at.normal));
  return at.position - std::min(height / slope, 0.5F * hit.t) * ray.direction;
}

/// What the rays of a batch met, and whether the way back is blocked. A ray may slip through an
/// edge, some in a million do; then the way back, which is not quite the same, is closed. Without
/// this rule the insides of solids get samples, since a particle that is in stays in.
struct Collisions {
  std::vector<SurfacePoint> points;
  std::vector<std::uint8_t> leaked;
};

Collisions find_collisions(const Scene& scene, const RayCaster& caster, const Batch& batch) {
  Collisions found;
  found.points.resize(batch.rays.size());
  std::vector<Ray> back;
  back.reserve(batch.rays.size());
  for (std::size_t i = 0; i < batch.rays.size(); ++i) {
    const Vec3f& origin = batch.rays[i].origin;
    if (!batch.hits[i].escaped()) found.points[i] = surface_at(scene, batch.rays[i], batch.hits[i]);
    const SurfacePoint& at = found.points[i];
    const Vec3f from =
        batch.hits[i].escaped() ? origin : offset_origin(scene, at.position, at.normal);
    const float distance = (origin - from).norm();
    back.push_back({from, distance > 0.0F ? Vec3f((origin - from) / distance) : Vec3f::UnitZ(),
                    0.0F, distance});
  }
  found.leaked.assign(back.size(), 0);
  caster.occluded(back, found.leaked);
  return found;
}

void collide(const Scene& scene, const RayCaster& caster, Batch& batch, int warm_up,
             const ParticleSettings& s, SurfacePoints& kept) {
  const Collisions collisions = find_collisions(scene, caster, batch);
  std::size_t alive = 0;
  for (std::size_t i = 0; i < batch.rays.size(); ++i) {
    if (batch.hits[i].escaped() || collisions.leaked[i]) continue;
    const SurfacePoint& point = collisions.points[i];
    Particle particle = batch.particles[i];
    ++particle.collisions;
    if (particle.collisions > warm_up && kept.size() < s.wanted) {
      kept.positions.push_back(point.position);
      kept.normals.push_back(point.normal);
      kept.triangles.push_back(point.triangle);
    }
    if (particle.collisions >= warm_up + s.kept_reflections) continue;
    const float u = particle.random.uniform();
    const float v = particle.random.uniform();
    batch.rays[alive] = {step_back(scene, batch.rays[i], batch.hits[i], point),
                         cosine_direction(point.normal, u, v)};
    batch.particles[alive] = particle;
    ++alive;
  }
  batch.rays.resize(alive);
  batch.particles.resize(alive, Particle{Random(0, 0), 0});
}

}  // namespace

SurfacePoints trace_particles(const Scene& scene, const RayCaster& caster,
                              const ParticleSettings& settings) {
  SurfacePoints kept;
  Batch batch;
  int warm_up = settings.warm_up_reflections;
  std::size_t rays_used = 0;
  for (std::uint64_t first = settings.first_particle;
       kept.size() < settings.wanted && rays_used < settings.ray_budget; first += kBatch) {
    if (rays_used > settings.ray_budget / 2 && kept.size() < settings.wanted / 4) warm_up = 0;
    start_batch(batch, settings, first);
    while (!batch.rays.empty() && kept.size() < settings.wanted) {
      batch.hits.resize(batch.rays.size());
      caster.intersect_incoherent(batch.rays, batch.hits);
      rays_used += batch.rays.size();
      collide(scene, caster, batch, warm_up, settings, kept);
    }
  }
  return kept;
}

namespace {

/// How good a view p has: front faces count for it, back faces (it is inside a solid) weigh against
/// it, and distance decides between places that both see everything.
double view_score(const Scene& scene, const RayCaster& caster, const Vec3f& p,
                  const std::vector<Vec3f>& directions) {
  std::vector<Ray> rays;
  for (const Vec3f& d : directions) rays.push_back({p, d});
  std::vector<Hit> hits(rays.size());
  caster.intersect_incoherent(rays, hits);
  double score = 0.0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].escaped()) continue;
    const bool front = surface_at(scene, rays[i], hits[i]).front;
    // Far walls count most: a nave before the gap behind it.
    score += front ? 0.2 + std::min(1.0F, 8.0F * hits[i].t / scene.diagonal()) : -4.0;
  }
  return score;
}

/// The best place so far among those that see anything.
struct Best {
  Vec3f place = Vec3f::Zero();
  double score = 0.0;
  bool sees = false;
  void offer(const Vec3f& p, double s) {
    if (s == 0.0 || (sees && s <= score)) return;
    *this = {p, s, true};
  }
};

/// Where nothing is ahead of a surface: so far in front of it, as a share of the scene.
constexpr float kOpenShare = 0.01F;

}  // namespace

Vec3f find_start(const Scene& scene, const RayCaster& caster, std::uint64_t stream) {
  constexpr int kPlaces = 512;
  constexpr int kDirections = 128;
  std::vector<Vec3f> directions;
  Random direction_random(stream, kPlaces);
  for (int i = 0; i < kDirections; ++i) {
    const float u = (static_cast<float>(i) + direction_random.uniform()) / kDirections;
    directions.push_back(sphere_direction(u, direction_random.uniform()));
  }
  Best best;
  for (int k = 0; k < kPlaces; ++k) {
    Random random(stream, k);
    const float x = random.uniform();
    const float y = random.uniform();
    const float z = random.uniform();
    const Vec3f p =
        scene.bounds_min + (scene.bounds_max - scene.bounds_min).cwiseProduct(Vec3f(x, y, z));
    best.offer(p, view_score(scene, caster, p, directions));
  }
  if (best.score > 0.0) return best.place;
  // A box mostly empty, for a speck far away, or faces turned inside out: look in front of
  // surfaces, and take the best there is.
  const std::vector<double> cumulative = cumulative_areas(scene);
  for (int k = 0; k < kPlaces; ++k) {
    Random random(stream, kPlaces + 1 + k);
    const AreaPoint at = area_point(cumulative, k, kPlaces, stream, random);
    const Vec3f normal = triangle_normal(scene, at.triangle);
    const Vec3f origin =
        offset_origin(scene, triangle_point(scene, at.triangle, at.u, at.v), normal);
    const Hit hit = caster.intersect({origin, normal});
    const float ahead = hit.escaped() ? kOpenShare * scene.diagonal() : 0.5F * hit.t;
    const Vec3f p = origin + ahead * normal;
    best.offer(p, view_score(scene, caster, p, directions));
  }
  if (!best.sees) {
    throw UserError(
        "samples.start: no point that was tried sees a surface; give a start point [x, y, z] in "
        "the open");
  }
  return best.place;
}

}  // namespace prt
