#include "transport/hemisphere.h"

#include "bases/depth_basis.h"

namespace prt {

namespace {

/// Order of directions in tiles of 8 × 2, so that the 16 rays of a packet stay together.
std::vector<int> tiled_order(const HemisphereDirections& directions) {
  std::vector<int> order;
  order.reserve(directions.count());
  for (int y = 0; y < directions.height(); y += 2) {
    for (int x = 0; x < directions.width(); x += 8) {
      for (int dy = 0; dy < 2 && y + dy < directions.height(); ++dy) {
        for (int dx = 0; dx < 8 && x + dx < directions.width(); ++dx) {
          order.push_back((y + dy) * directions.width() + x + dx);
        }
      }
    }
  }
  return order;
}

}  // namespace

HemisphereRays cast_hemispheres(const Scene& scene, const RayCaster& caster,
                                const SampleSet& samples, const SenderSearch& search,
                                const HemisphereDirections& directions, std::uint32_t begin,
                                std::uint32_t end, float bound) {
  const auto count = static_cast<std::size_t>(directions.count());
  HemisphereRays out;
  out.distances.resize((end - begin) * count);
  out.senders.resize((end - begin) * count);
  const std::vector<int> order = tiled_order(directions);
  std::vector<Ray> rays(count);
  std::vector<Hit> hits(count);
  std::vector<SurfacePoint> points(count);
  std::vector<int> met(count);  // direction of each point
  std::vector<std::uint32_t> found(count);
  double area = 0.0;
  for (std::uint32_t s = begin; s < end; ++s) {
    const Mat3f frame = samples.frame(s);
    const Vec3f origin = offset_origin(scene, samples.positions[s], samples.normals[s]);
    for (std::size_t k = 0; k < count; ++k) {
      rays[k].origin = origin;
      rays[k].direction = frame * directions.direction(order[k]);
    }
    caster.intersect_coherent(rays, hits);
    double escaped = 0.0;
    double lost = 0.0;
    std::uint16_t* distance = out.distances.data() + (s - begin) * count;
    std::uint32_t* sender = out.senders.data() + (s - begin) * count;
    std::size_t met_count = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const int d = order[k];
      distance[d] = pack_depth(hits[k].t, bound, hits[k].escaped());
      if (hits[k].escaped()) {
        sender[d] = kEscapedSender;
        escaped += directions.weights()[d];
        continue;
      }
      points[met_count] = surface_at(scene, rays[k], hits[k]);
      out.back_hits += points[met_count].front ? 0 : 1;
      met[met_count++] = d;
    }
    search.find({points.data(), met_count}, {found.data(), met_count});
    for (std::size_t k = 0; k < met_count; ++k) {
      sender[met[k]] = found[k] == kNone ? kLostSender : found[k];
      if (found[k] == kNone) lost += directions.weights()[met[k]];
    }
    out.escaped_share += escaped * samples.areas[s];
    out.lost_share += lost * samples.areas[s];
    area += samples.areas[s];
  }
  if (area > 0.0) {
    out.escaped_share /= area;
    out.lost_share /= area;
  }
  return out;
}

}  // namespace prt
