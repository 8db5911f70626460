// What a hemispherical ray costs, part by part, on the samples of a package:
//   bench_rays out/paper/paper.prt.glb
// Every part is timed in each of several rounds, so that all see the same machine; medians over the
// rounds. One thread.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "domains/directions.h"
#include "package/read.h"
#include "scene/embree/embree_query.h"
#include "scene/embree/embree_ray_caster.h"
#include "transport/hemisphere.h"
#include "transport/sender_search.h"

namespace prt {
namespace {

constexpr int kRounds = 7;
constexpr std::uint32_t kSamples = 256;  // per round, spread over the scene
constexpr int kDirections = 2016;
constexpr unsigned kPacket = 16;

/// Seconds that `work` takes.
template <typename Work>
double seconds(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// The scene in Embree with nothing of ours around it: the limit.
class BareEmbree {
 public:
  explicit BareEmbree(const Scene& scene) : device_(rtcNewDevice("threads=1")) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), scene.positions.size()));
    for (const Vec3f& p : scene.positions) {
      positions = std::copy(p.data(), p.data() + 3, positions);
    }
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), scene.triangles.size()));
    for (const Triangle& t : scene.triangles) {
      indices = std::copy(t.vertex.begin(), t.vertex.end(), indices);
    }
    rtcCommitGeometry(geometry);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~BareEmbree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareEmbree(const BareEmbree&) = delete;
  BareEmbree& operator=(const BareEmbree&) = delete;

  /// Casts the rays in packets of 16; returns how many hit.
  std::size_t cast(const std::vector<Ray>& rays) const {
    Query query(true);
    std::size_t hits = 0;
    for (std::size_t begin = 0; begin + kPacket <= rays.size(); begin += kPacket) {
      alignas(64) RTCRayHit16 packet;
      alignas(64) int valid[kPacket];
      for (unsigned i = 0; i < kPacket; ++i) {
        const Ray& ray = rays[begin + i];
        valid[i] = -1;
        packet.ray.org_x[i] = ray.origin.x();
        packet.ray.org_y[i] = ray.origin.y();
        packet.ray.org_z[i] = ray.origin.z();
        packet.ray.dir_x[i] = ray.direction.x();
        packet.ray.dir_y[i] = ray.direction.y();
        packet.ray.dir_z[i] = ray.direction.z();
        packet.ray.tnear[i] = 0.0F;
        packet.ray.tfar[i] = kInfinity;
        packet.ray.time[i] = 0.0F;
        packet.ray.mask[i] = ~0U;
        packet.ray.flags[i] = 0;
        packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      }
      embree_intersect16(valid, scene_, query, packet);
      for (unsigned i = 0; i < kPacket; ++i) hits += packet.hit.geomID[i] == 0 ? 1 : 0;
    }
    return hits;
  }

 private:
  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

/// Rays of one sample in tiles of 8 x 2 directions, as the bake casts them.
std::vector<Ray> hemisphere(const Scene& scene, const SampleSet& samples, std::uint32_t s,
                            const HemisphereDirections& directions) {
  const Mat3f frame = samples.frame(s);
  const Vec3f origin = offset_origin(scene, samples.positions[s], samples.normals[s]);
  const int columns = (directions.width() + 7) / 8;
  std::vector<Ray> rays;
  for (int tile = 0; tile < columns * (directions.height() / 2); ++tile) {
    for (int lane = 0; lane < 16; ++lane) {
      const int x = tile % columns * 8 + lane % 8;
      const int y = tile / columns * 2 + lane / 8;
      if (x >= directions.width()) continue;
      rays.push_back({origin, frame * directions.direction(y * directions.width() + x)});
    }
  }
  return rays;
}

int run(const std::string& file) {
  const Package package = read_package(file);
  const Scene& scene = package.scene;
  const SampleSet& samples = package.samples;
  const auto caster = make_embree_ray_caster(scene);
  const BareEmbree bare(scene);
  const SenderSearch search(scene, samples);
  const float cell = 3.25F * *std::max_element(samples.radii.begin(), samples.radii.end());
  const SampleGrid grid(samples.positions, samples.normals, cell);
  const HemisphereDirections directions(kDirections);
  const std::size_t step = std::max<std::size_t>(1, samples.size() / (kSamples * kRounds));
  std::map<std::string, std::vector<double>> nanoseconds;
  std::size_t differing = 0;
  for (int round = 0; round < kRounds; ++round) {
    // Sample by sample, as the bake goes, so that rays and hits stay in the caches.
    std::map<std::string, double> sums;
    std::size_t count = 0;
    for (std::uint32_t k = 0; k < kSamples; ++k) {
      const auto s = static_cast<std::uint32_t>((k * kRounds + round) * step % samples.size());
      const std::vector<Ray> rays = hemisphere(scene, samples, s, directions);
      std::vector<Hit> hits(rays.size());
      std::vector<SurfacePoint> points(rays.size());
      std::vector<std::uint32_t> by_texels(rays.size());
      std::vector<std::uint32_t> by_grid(rays.size());
      count += rays.size();
      sums["1 bare rtcIntersect16"] += seconds([&] { (void)bare.cast(rays); });
      sums["2 RayCaster (tie rule)"] += seconds([&] { caster->intersect_coherent(rays, hits); });
      std::erase_if(hits, [](const Hit& hit) { return hit.escaped(); });
      sums["3 point on the surface"] += seconds([&] {
        for (std::size_t i = 0; i < hits.size(); ++i) {
          points[i] = surface_at(scene, rays[i], hits[i]);
        }
      });
      sums["4 nearest sample by texels"] += seconds([&] {
        search.find({points.data(), hits.size()}, {by_texels.data(), hits.size()});
      });
      sums["5 nearest sample by grid"] += seconds([&] {
        for (std::size_t i = 0; i < hits.size(); ++i) {
          by_grid[i] = grid.nearest(points[i].position, points[i].normal, cell);
        }
      });
      for (std::size_t i = 0; i < hits.size(); ++i) {
        differing += by_grid[i] != kNone && by_texels[i] != by_grid[i] ? 1 : 0;
      }
      sums["6 the whole cast"] += seconds([&] {
        (void)cast_hemispheres(scene, *caster, samples, search, directions, s, s + 1,
                               scene.diagonal());
      });
    }
    for (const auto& [part, sum] : sums) {
      nanoseconds[part].push_back(1e9 * sum / static_cast<double>(count));
    }
  }
  for (const auto& [part, values] : nanoseconds) {
    const double middle = median(values);
    fmt::print("{:28} {:7.1f} ns  {:7.2f} M/s  (least {:.1f}, most {:.1f})\n", part, middle,
               1e3 / middle, *std::min_element(values.begin(), values.end()),
               *std::max_element(values.begin(), values.end()));
  }
  fmt::print("differing answers of texels and grid: {}\n", differing);
  return 0;
}

}  // namespace
}  // namespace prt

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: bench_rays PACKAGE.prt.glb\n");
    return 2;
  }
  try {
    return prt::run(argv[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_rays: {}\n", error.what());
    return 1;
  }
}
