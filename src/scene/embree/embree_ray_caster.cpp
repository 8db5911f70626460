#include "scene/embree/embree_ray_caster.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "scene/closest_point.h"
#include "scene/embree/coplanar.h"
#include "scene/embree/embree_query.h"

namespace prt {
namespace {

constexpr unsigned kPacket = 16;
/// Hits with a barycentric weight below this may lie on an edge, and so hit the neighbour as well.
constexpr float kNearEdge = 0x1p-12F;
/// Rounding of Embree's distances, relative to the coordinates.
constexpr float kTie = 0x1p-20F;

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error("Embree cannot build the ray caster: " + what);
}

/// An Embree device that closes itself.
class Device {
 public:
  explicit Device(const std::string& isa) {
    const std::string config = isa.empty() ? "threads=1" : "threads=1,isa=" + isa;
    device_ = rtcNewDevice(config.c_str());
    if (device_ == nullptr) fail(fmt::format("no device for '{}'", config));
  }
  ~Device() { rtcReleaseDevice(device_); }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  [[nodiscard]] RTCDevice get() const { return device_; }
  void check(const char* step) const {
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_NONE) fail(fmt::format("{}: error {}", step, static_cast<int>(error)));
  }

 private:
  RTCDevice device_ = nullptr;
};

/// The triangles of one Embree geometry: Embree's primitive number to Scene's triangle.
struct Group {
  const Scene* scene = nullptr;
  std::vector<std::uint32_t> triangles;
};

/// Rejects hits on the holes of alpha masks.
void reject_holes(const RTCFilterFunctionNArguments* arguments) {
  const auto& group = *static_cast<const Group*>(arguments->geometryUserPtr);
  const unsigned count = arguments->N;
  for (unsigned i = 0; i < count; ++i) {
    if (arguments->valid[i] != -1) continue;
    const std::uint32_t triangle = group.triangles[RTCHitN_primID(arguments->hit, count, i)];
    const float u = RTCHitN_u(arguments->hit, count, i);
    const float v = RTCHitN_v(arguments->hit, count, i);
    if (!opaque_at(*group.scene, triangle, u, v)) arguments->valid[i] = 0;
  }
}

/// What a point query needs to know in its callback.
struct PointQuery {
  const Scene& scene;
  std::span<const Group> groups;
  Vec3f point;
};

/// Shrinks the query's radius to the triangle's distance; true tells Embree that it changed.
bool shrink_to_triangle(RTCPointQueryFunctionArguments* arguments) {
  const auto& query = *static_cast<const PointQuery*>(arguments->userPtr);
  const auto& vertex =
      query.scene.triangles[query.groups[arguments->geomID].triangles[arguments->primID]].vertex;
  const auto& positions = query.scene.positions;
  const Vec3f nearest =
      closest_point(query.point, positions[vertex[0]], positions[vertex[1]], positions[vertex[2]]);
  const float distance = (nearest - query.point).norm();
  if (distance >= arguments->query->radius) return false;
  arguments->query->radius = distance;
  return true;
}

/// Finds the lowest of all triangles that a ray meets on its way: meant for a very short way.
struct TieQuery : Query {
  explicit TieQuery(const Group* of)
      : Query(false,
              [](const RTCFilterFunctionNArguments* arguments) {
                static_cast<TieQuery*>(query_of(arguments))->see(arguments);
              }),
        groups(of) {}

  const Group* groups;
  Hit lowest;

 private:
  /// Takes note of a hit and rejects it, so that the search goes on.
  void see(const RTCFilterFunctionNArguments* arguments) {
    if (arguments->valid[0] != -1) return;
    arguments->valid[0] = 0;
    const Group& group = groups[RTCHitN_geomID(arguments->hit, 1, 0)];
    const std::uint32_t triangle = group.triangles[RTCHitN_primID(arguments->hit, 1, 0)];
    if (triangle >= lowest.triangle) return;
    lowest = {triangle, RTCRayN_tfar(arguments->ray, 1, 0), RTCHitN_u(arguments->hit, 1, 0),
              RTCHitN_v(arguments->hit, 1, 0)};
  }
};

RTCRayHit single_ray(const Ray& ray) {
  RTCRayHit single;
  single.ray = {ray.origin.x(),
                ray.origin.y(),
                ray.origin.z(),
                ray.t_near,
                ray.direction.x(),
                ray.direction.y(),
                ray.direction.z(),
                0.0F,
                ray.t_far,
                std::numeric_limits<unsigned>::max(),
                0,
                0};
  single.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  single.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return single;
}

/// Lanes without a ray get one that Embree takes for inactive (t_near beyond t_far): below AVX-512
/// it cuts a packet of 16 into smaller ones and looks at all lanes, whatever the mask says.
void load_packet(std::span<const Ray> rays, RTCRay16& packet) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray& ray = rays[i];
    packet.org_x[i] = ray.origin.x();
    packet.org_y[i] = ray.origin.y();
    packet.org_z[i] = ray.origin.z();
    packet.dir_x[i] = ray.direction.x();
    packet.dir_y[i] = ray.direction.y();
    packet.dir_z[i] = ray.direction.z();
    packet.tnear[i] = ray.t_near;
    packet.tfar[i] = ray.t_far;
  }
  for (std::size_t i = rays.size(); i < kPacket; ++i) {
    packet.org_x[i] = packet.org_y[i] = packet.org_z[i] = 0.0F;
    packet.dir_x[i] = packet.dir_y[i] = packet.dir_z[i] = 1.0F;
    packet.tnear[i] = 1.0F;
    packet.tfar[i] = 0.0F;
  }
}

/// Fields that every ray of every packet shares.
void set_constants(RTCRay16& packet) {
  for (unsigned i = 0; i < kPacket; ++i) {
    packet.time[i] = 0.0F;
    packet.mask[i] = std::numeric_limits<unsigned>::max();
    packet.id[i] = i;
    packet.flags[i] = 0;
  }
}

class EmbreeRayCaster final : public RayCaster {
 public:
  EmbreeRayCaster(const Scene& scene, const std::string& isa) : device_(isa), scene_(scene) {
    contested_ = contested_triangles(scene);
    for (Group& group : groups_) group.scene = &scene;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
      const bool masked = scene.materials[scene.triangles[t].material].alpha_mask;
      groups_[masked ? kMasked : kOpaque].triangles.push_back(t);
    }
    embree_scene_ = rtcNewScene(device_.get());
    rtcSetSceneBuildQuality(embree_scene_, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(embree_scene_, kSceneFlags);
    try {
      for (unsigned id = 0; id < groups_.size(); ++id) attach(id);
      rtcCommitScene(embree_scene_);
      device_.check("building the hierarchy");
    } catch (...) {
      rtcReleaseScene(embree_scene_);
      throw;
    }
  }
  ~EmbreeRayCaster() override { rtcReleaseScene(embree_scene_); }
  EmbreeRayCaster(const EmbreeRayCaster&) = delete;
  EmbreeRayCaster& operator=(const EmbreeRayCaster&) = delete;

  [[nodiscard]] Hit intersect(const Ray& ray) const override {
    Query query(false);
    return intersect_single(ray, query);
  }

  void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const override {
    intersect_packets(rays, hits, true);
  }

  void intersect_incoherent(std::span<const Ray> rays, std::span<Hit> hits) const override {
    assert(rays.size() == hits.size());
    Query query(false);
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = intersect_single(rays[i], query);
  }

  void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
    assert(rays.size() == blocked.size());
    Query query(false);
    RTCRay16 packet;
    set_constants(packet);
    for (std::size_t begin = 0; begin < rays.size(); begin += kPacket) {
      const std::size_t count = std::min<std::size_t>(kPacket, rays.size() - begin);
      load_packet(rays.subspan(begin, count), packet);
      embree_occluded16(valid_lanes(count), embree_scene_, query, packet);
      for (std::size_t i = 0; i < count; ++i) blocked[begin + i] = packet.tfar[i] < 0.0F ? 1 : 0;
    }
  }

  [[nodiscard]] float closest_distance(const Vec3f& p, float limit) const override {
    RTCPointQuery query{p.x(), p.y(), p.z(), 0.0F, limit};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    PointQuery ours{scene_, groups_, p};
    rtcPointQuery(embree_scene_, &query, &context, shrink_to_triangle, &ours);
    return query.radius;
  }

 private:
  enum GroupId : unsigned { kOpaque = 0, kMasked = 1 };

  void attach(unsigned id) {
    const Group& group = groups_[id];
    if (group.triangles.empty()) return;
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    fill(geometry, group);
    rtcSetGeometryUserData(geometry, &groups_[id]);
    if (id == kMasked) {
      rtcSetGeometryIntersectFilterFunction(geometry, reject_holes);
      rtcSetGeometryOccludedFilterFunction(geometry, reject_holes);
    }
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(embree_scene_, geometry, id);
    rtcReleaseGeometry(geometry);
    device_.check("attaching triangles");
  }

  /// Embree copies the vertices: its reads run past the end of a plain array.
  void fill(RTCGeometry geometry, const Group& group) const {
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), scene_.positions.size()));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), group.triangles.size()));
    device_.check("allocating its buffers");
    for (const Vec3f& position : scene_.positions) {
      vertices = std::copy_n(position.data(), 3, vertices);
    }
    for (const std::uint32_t triangle : group.triangles) {
      indices = std::copy_n(scene_.triangles[triangle].vertex.data(), 3, indices);
    }
  }

  [[nodiscard]] Hit intersect_single(const Ray& ray, Query& query) const {
    RTCRayHit single = single_ray(ray);
    embree_intersect1(embree_scene_, query, single);
    return hit_of(ray, single.hit.geomID, single.hit.primID, single.ray.tfar, single.hit.u,
                  single.hit.v);
  }

  void intersect_packets(std::span<const Ray> rays, std::span<Hit> hits, bool coherent) const {
    assert(rays.size() == hits.size());
    Query query(coherent);
    RTCRayHit16 packet;
    set_constants(packet.ray);
    for (std::size_t begin = 0; begin < rays.size(); begin += kPacket) {
      const std::size_t count = std::min<std::size_t>(kPacket, rays.size() - begin);
      load_packet(rays.subspan(begin, count), packet.ray);
      std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
      std::fill_n(packet.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
      embree_intersect16(valid_lanes(count), embree_scene_, query, packet);
      for (std::size_t i = 0; i < count; ++i) {
        hits[begin + i] = hit_of(rays[begin + i], packet.hit.geomID[i], packet.hit.primID[i],
                                 packet.ray.tfar[i], packet.hit.u[i], packet.hit.v[i]);
      }
    }
  }

  [[nodiscard]] Hit hit_of(const Ray& ray, unsigned geometry, unsigned primitive, float t, float u,
                           float v) const {
    if (geometry == RTC_INVALID_GEOMETRY_ID) return {};
    const Hit hit{groups_[geometry].triangles[primitive], t, u, v};
    const bool near_edge = std::min({u, v, 1.0F - u - v}) < kNearEdge;
    const bool contested = !contested_.empty() && contested_[hit.triangle] != 0;
    return near_edge || contested ? lowest_of_tie(ray, hit) : hit;
  }

  /// Embree keeps whichever of several hits at one distance it comes upon first, and its packets
  /// and single rays round distances differently. Nothing is nearer than the hit, so all that the
  /// ray meets up to just behind it is as near, and the answer no longer depends on the way it was
  /// asked.
  [[nodiscard]] Hit lowest_of_tie(const Ray& ray, const Hit& hit) const {
    TieQuery query(groups_.data());
    RTCRayHit single = single_ray(ray);
    single.ray.tfar = hit.t + kTie * (hit.t + ray.origin.cwiseAbs().maxCoeff());
    embree_intersect1(embree_scene_, query, single);
    return query.lowest.escaped() || query.lowest.t > ray.t_far ? hit : query.lowest;
  }

  /// Mask of a packet whose first `count` lanes hold rays.
  static const int* valid_lanes(std::size_t count) {
    alignas(64) static constexpr std::array<std::array<int, kPacket>, kPacket + 1> kMasks = [] {
      std::array<std::array<int, kPacket>, kPacket + 1> masks{};
      for (std::size_t lanes = 0; lanes <= kPacket; ++lanes) {
        for (std::size_t i = 0; i < lanes; ++i) masks[lanes][i] = -1;
      }
      return masks;
    }();
    return kMasks[count].data();
  }

  Device device_;
  const Scene& scene_;
  std::array<Group, 2> groups_;
  std::vector<std::uint8_t> contested_;  ///< contested_triangles()
  RTCScene embree_scene_ = nullptr;
};

}  // namespace

std::unique_ptr<RayCaster> make_embree_ray_caster(const Scene& scene, const std::string& isa) {
  return std::make_unique<EmbreeRayCaster>(scene, isa);
}

std::string best_embree_isa() {
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl")) {
    return "avx512";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "avx2";
  if (__builtin_cpu_supports("avx")) return "avx";
  if (__builtin_cpu_supports("sse4.2")) return "sse4.2";
  return "sse2";
}

}  // namespace prt
