#include "transport/photons.h"

#include <algorithm>
#include <vector>

#include "base/random.h"

namespace prt {

namespace {

constexpr std::size_t kPhotonBatch = 1024;
constexpr int kPlacementTries = 64;

/// Draws points uniform in area over the cells of one cluster.
class CellEmitter {
 public:
  CellEmitter(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
              const SenderSearch& search, std::uint32_t cluster)
      : scene_(scene), caster_(caster), samples_(samples), search_(search) {
    begin_ = samples.cluster_begin[cluster];
    cumulative_.push_back(0.0);
    for (std::uint32_t s = begin_; s < samples.cluster_begin[cluster + 1]; ++s) {
      cumulative_.push_back(cumulative_.back() + samples.areas[s]);
    }
  }
  [[nodiscard]] double area() const { return cumulative_.back(); }

  struct Start {
    SurfacePoint point;
    std::uint32_t sample;
  };
  /// `share` in [0, 1) picks the cell by area.
  Start draw(double share, Random& random) const {
    const auto above =
        std::upper_bound(cumulative_.begin() + 1, cumulative_.end() - 1, share * area());
    const auto sample = begin_ + static_cast<std::uint32_t>(above - cumulative_.begin() - 1);
    for (int i = 0; i < kPlacementTries; ++i) {
      const auto point = try_place(sample, random);
      if (point.triangle != kNone) return {point, sample};
    }
    return {{samples_.positions[sample], samples_.normals[sample], samples_.triangles[sample]},
            sample};
  }

 private:
  /// A uniform point of the disk around the sample, dropped onto the surface; none if it is not in
  /// the sample's cell.
  SurfacePoint try_place(std::uint32_t sample, Random& random) const {
    const float reach = 1.25F * samples_.radii[sample];
    const float x = 2.0F * random.uniform() - 1.0F;
    const float y = 2.0F * random.uniform() - 1.0F;
    if (x * x + y * y > 1.0F) return {};
    const Mat3f frame = samples_.frame(sample);
    const Vec3f& n = samples_.normals[sample];
    const Vec3f above = samples_.positions[sample] + reach * (frame * Vec3f(x, y, 0.5F));
    const Ray down{above, -n, 0.0F, reach};
    const Hit hit = caster_.intersect(down);
    if (hit.escaped()) return {};
    const SurfacePoint point = surface_at(scene_, down, hit);
    if (search_.find_near(point) != sample) return {};
    const Vec3f from = offset_origin(scene_, point.position, point.normal);
    if (!caster_.visible(from, offset_origin(scene_, samples_.positions[sample], n))) return {};
    return point;
  }

  const Scene& scene_;
  const RayCaster& caster_;
  const SampleSet& samples_;
  const SenderSearch& search_;
  std::uint32_t begin_ = 0;
  std::vector<double> cumulative_;
};

struct Photon {
  Random random;
  std::uint32_t origin;  // function column
  Vec3f weight;
  int flights = 0;
};

/// Weight after reflection and whether the photon goes on; roulette by the largest albedo.
bool reflect(Photon& photon, const Vec3f& albedo) {
  const float survival = albedo.maxCoeff();
  if (!(photon.random.uniform() < survival)) return false;
  photon.weight = photon.weight.cwiseProduct(albedo) / survival;
  return true;
}

}  // namespace

PhotonTransfer shoot_photons(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                             const SenderSearch& search, std::uint32_t cluster,
                             const MatrixF& functions, int channels,
                             const PhotonSettings& settings) {
  const Eigen::Index k = functions.rows();
  PhotonTransfer out;
  MatrixD power = MatrixD::Zero(static_cast<Eigen::Index>(samples.size()), channels * k);
  const CellEmitter emitter(scene, caster, samples, search, cluster);
  const MatrixF columns = functions.transpose();  // one row per sample of the cluster
  std::vector<Photon> photons;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  const auto launch = [&](Photon photon, const SurfacePoint& point) {
    const float u = photon.random.uniform();
    const float v = photon.random.uniform();
    rays.push_back(
        {offset_origin(scene, point.position, point.normal), cosine_direction(point.normal, u, v)});
    photons.push_back(photon);
  };
  for (std::uint64_t first = 0; first < settings.photons; first += kPhotonBatch) {
    photons.clear();
    rays.clear();
    for (std::uint64_t i = first; i < std::min(first + kPhotonBatch, settings.photons); ++i) {
      Photon photon{Random(settings.stream, i), 0, Vec3f::Ones(), 0};
      const double share = (static_cast<double>(i) + photon.random.uniform()) /
                           static_cast<double>(settings.photons);
      const auto start = emitter.draw(share, photon.random);
      photon.origin = start.sample - samples.cluster_begin[cluster];
      if (reflect(photon, albedo_at(scene, start.point.triangle, start.point.u, start.point.v))) {
        launch(photon, start.point);
      }
    }
    while (!rays.empty()) {
      hits.resize(rays.size());
      caster.intersect_incoherent(rays, hits);
      const std::vector<Ray> flown = std::move(rays);
      const std::vector<Photon> travellers = std::move(photons);
      rays.clear();
      photons.clear();
      for (std::size_t i = 0; i < flown.size(); ++i) {
        ++out.flights;
        if (hits[i].escaped()) {
          ++out.escaped;
          continue;
        }
        Photon photon = travellers[i];
        ++photon.flights;
        const SurfacePoint point = surface_at(scene, flown[i], hits[i]);
        const std::uint32_t receiver = search.find(point);
        if (receiver == kNone) {
          ++out.lost;
        } else {
          for (int c = 0; c < channels; ++c) {
            power.row(receiver).segment(c * k, k) +=
                (photon.weight[c] * columns.row(photon.origin)).cast<double>();
          }
        }
        if (settings.bounces >= 0 && photon.flights >= settings.bounces) continue;
        if (reflect(photon, albedo_at(scene, point.triangle, point.u, point.v)))
          launch(photon, point);
      }
    }
  }
  const double per_photon =
      emitter.area() / static_cast<double>(std::max<std::uint64_t>(1, settings.photons));
  VectorD density(samples.size());
  for (std::size_t s = 0; s < samples.size(); ++s) density[s] = per_photon / samples.areas[s];
  out.irradiance = (density.asDiagonal() * power).cast<float>();
  return out;
}

}  // namespace prt
