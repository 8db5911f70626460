#include "transport/photons.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/random.h"

namespace prt {

namespace {

constexpr std::size_t kPhotonBatch = 1024;
constexpr float kThird = 1.0F / 3.0F;

/// Draws points uniform in area over the cells of one cluster, out of those that measured the
/// cells.
class CellEmitter {
 public:
  CellEmitter(const Scene& scene, const SampleSet& samples, const CellPoints& points,
              std::uint32_t cluster)
      : scene_(scene), samples_(samples), points_(points) {
    begin_ = samples.cluster_begin[cluster];
    const std::uint32_t end = samples.cluster_begin[cluster + 1];
    for (std::uint32_t s = begin_; s < end; ++s) {
      cumulative_.push_back(cumulative_.back() + samples.areas[s]);
    }
    for (std::size_t k = 0; k < points.samples.size(); ++k) {
      if (points.samples[k] >= begin_ && points.samples[k] < end) own_.push_back(k);
    }
    std::stable_sort(own_.begin(), own_.end(), [&](std::size_t a, std::size_t b) {
      return points.samples[a] < points.samples[b];
    });
    for (std::uint32_t s = begin_; s <= end; ++s) {
      const auto at =
          std::lower_bound(own_.begin(), own_.end(), s,
                           [&](std::size_t k, std::uint32_t x) { return points.samples[k] < x; });
      cell_begin_.push_back(static_cast<std::size_t>(at - own_.begin()));
    }
  }
  [[nodiscard]] double area() const { return cumulative_.back(); }

  struct Start {
    SurfacePoint point;
    std::uint32_t sample;
  };
  /// `share` in [0, 1) picks the cell by area, and the point in it.
  [[nodiscard]] Start draw(double share) const {
    const double along = share * area();
    const auto above = std::upper_bound(cumulative_.begin() + 1, cumulative_.end() - 1, along);
    const auto i = static_cast<std::size_t>(above - cumulative_.begin() - 1);
    const auto sample = begin_ + static_cast<std::uint32_t>(i);
    const std::size_t count = cell_begin_[i + 1] - cell_begin_[i];
    if (count == 0) {  // the cell is smaller than the points can tell
      return {{samples_.positions[sample], samples_.normals[sample], samples_.triangles[sample],
               kThird, kThird},
              sample};
    }
    const double within = (along - cumulative_[i]) / (cumulative_[i + 1] - cumulative_[i]);
    const auto k =
        std::min(count - 1, static_cast<std::size_t>(within * static_cast<double>(count)));
    return {point(own_[cell_begin_[i] + k], samples_.normals[sample]), sample};
  }

 private:
  [[nodiscard]] SurfacePoint point(std::size_t k, const Vec3f& side) const {
    const std::uint32_t triangle = points_.triangles[k];
    const float u = points_.barycentric[2 * k];
    const float v = points_.barycentric[2 * k + 1];
    const Vec3f front = triangle_normal(scene_, triangle);
    const bool is_front = front.dot(side) > 0.0F;
    return {triangle_point(scene_, triangle, u, v),
            is_front ? front : Vec3f(-front),
            triangle,
            u,
            v,
            is_front};
  }

  const Scene& scene_;
  const SampleSet& samples_;
  const CellPoints& points_;
  std::uint32_t begin_ = 0;
  std::vector<double> cumulative_{0.0};  ///< areas
  std::vector<std::size_t> own_;         ///< the cluster's points, cell by cell
  std::vector<std::size_t> cell_begin_;
};

struct Photon {
  Random random;
  std::uint32_t origin;  // function column
  Vec3f weight;
  int flights = 0;
};

/// At albedo 0.9999 half the photons still fly after so many flights (ln 2 · 10,000) ...
constexpr int kManyFlights = 6931;
/// ... which is told of a batch of at least so many; one in e^100 still flies after the most.
constexpr std::size_t kTellingBatch = 64;
constexpr int kMostFlights = 1'000'000;

/// Weight after reflection and whether the photon goes on; roulette by the largest albedo.
bool reflect(Photon& photon, const Vec3f& albedo) {
  const float survival = albedo.maxCoeff();
  if (!(photon.random.uniform() < survival)) return false;
  photon.weight = photon.weight.cwiseProduct(albedo) / survival;
  return true;
}

/// The photons of one sender cluster, flown batch by batch.
class PhotonFlight {
 public:
  PhotonFlight(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
               const SenderSearch& search, const MatrixF& functions, int channels, int bounces)
      : scene_(scene),
        caster_(caster),
        search_(search),
        columns_(functions.transpose()),
        channels_(channels),
        bounces_(bounces),
        power_(MatrixD::Zero(static_cast<Eigen::Index>(samples.size()),
                             channels * functions.rows())) {}

  /// Sends a photon on from a point, if it survives reflection there.
  void reflect_at(Photon photon, const SurfacePoint& point) {
    if (!reflect(photon, albedo_at(scene_, point.triangle, point.u, point.v))) return;
    const float u = photon.random.uniform();
    const float v = photon.random.uniform();
    rays_.push_back({offset_origin(scene_, point.position, point.normal),
                     cosine_direction(point.normal, u, v)});
    photons_.push_back(photon);
  }

  /// Flies all that are on their way until none is left; they start together.
  void fly() {
    const std::size_t started = rays_.size();
    for (int flight = 0; !rays_.empty(); ++flight) {
      const bool many =
          started >= kTellingBatch && flight >= kManyFlights && 2 * rays_.size() > started;
      if (bounces_ < 0 && (many || flight >= kMostFlights)) {
        throw UnsoundData(
            "photons are as good as never absorbed: some albedo is too near 1 in a closed space; "
            "lower it or set transport.bounces");
      }
      hits_.resize(rays_.size());
      caster_.intersect_incoherent(rays_, hits_);
      const std::vector<Ray> flown = std::exchange(rays_, {});
      const std::vector<Photon> travellers = std::exchange(photons_, {});
      for (std::size_t i = 0; i < flown.size(); ++i) arrive(travellers[i], flown[i], hits_[i]);
    }
  }

  /// Photons' values by sample, channels side by side; samples × (channels · functions).
  [[nodiscard]] const MatrixD& power() const { return power_; }

  std::uint64_t flights = 0, escaped = 0, lost = 0;

 private:
  void arrive(Photon photon, const Ray& ray, const Hit& hit) {
    ++flights;
    if (hit.escaped()) {
      ++escaped;
      return;
    }
    ++photon.flights;
    const SurfacePoint point = surface_at(scene_, ray, hit);
    const std::uint32_t receiver = search_.find(point);
    if (receiver == kNone) {
      ++lost;
    } else {
      deposit(photon, receiver);
    }
    if (bounces_ < 0 || photon.flights < bounces_) reflect_at(photon, point);
  }

  void deposit(const Photon& photon, std::uint32_t receiver) {
    const Eigen::Index k = columns_.cols();
    for (int c = 0; c < channels_; ++c) {
      power_.row(receiver).segment(c * k, k) +=
          (photon.weight[c] * columns_.row(photon.origin)).cast<double>();
    }
  }

  const Scene& scene_;
  const RayCaster& caster_;
  const SenderSearch& search_;
  MatrixF columns_;  ///< one row per sample of the cluster
  int channels_;
  int bounces_;
  MatrixD power_;
  std::vector<Photon> photons_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
};

}  // namespace

PhotonTransfer shoot_photons(const Scene& scene, const RayCaster& caster, const SampleSet& samples,
                             const SenderSearch& search, const CellPoints& points,
                             std::uint32_t cluster, const MatrixF& functions, int channels,
                             const PhotonSettings& settings) {
  const CellEmitter emitter(scene, samples, points, cluster);
  PhotonFlight flight(scene, caster, samples, search, functions, channels, settings.bounces);
  for (std::uint64_t first = 0; first < settings.photons; first += kPhotonBatch) {
    for (std::uint64_t i = first; i < std::min(first + kPhotonBatch, settings.photons); ++i) {
      Photon photon{Random(settings.stream, i), 0, Vec3f::Ones(), 0};
      const double share = (static_cast<double>(i) + photon.random.uniform()) /
                           static_cast<double>(settings.photons);
      const auto start = emitter.draw(share);
      photon.origin = start.sample - samples.cluster_begin[cluster];
      flight.reflect_at(photon, start.point);
    }
    flight.fly();
  }
  const double per_photon =
      emitter.area() / static_cast<double>(std::max<std::uint64_t>(1, settings.photons));
  VectorD density(samples.size());
  for (std::size_t s = 0; s < samples.size(); ++s) density[s] = per_photon / samples.areas[s];
  PhotonTransfer out;
  out.irradiance = (density.asDiagonal() * flight.power()).cast<float>();
  out.flights = flight.flights;
  out.escaped = flight.escaped;
  out.lost = flight.lost;
  return out;
}

}  // namespace prt
