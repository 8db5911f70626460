#include "methods/lb/work.h"

#include <algorithm>
#include <cmath>

#include "methods/common/work.h"
#include "methods/lb/regions.h"

namespace prt::lb {

namespace {

// Light functions and snapshots are made from so many candidates, mixtures and rows; what a product
// costs next to a ray was weighed on the gallery, a Cornell box and a room with columns.
constexpr double kProductsPerDepth = 360.0;
constexpr double kCandidatesPerRank = 4.0;
constexpr double kMixtures = 336.0;
constexpr double kEffectRows = 512.0;

/// How many times more snapshots a tolerance needs than the one that the figures were found with:
/// measured on the gallery, a Cornell box and a room with columns.
double rank_growth(double tolerance, const StageFigures& figures) {
  return std::sqrt(figure(figures, "options", "transport.tolerance", tolerance) / tolerance);
}

class Work {
 public:
  Work(const BakeSize& size, const OptionValues& options, const StageFigures& figures)
      : n_(size.samples),
        clusters_(size.clusters),
        per_cluster_(size.samples / size.clusters),
        directions_(options.get<double>("rays.directions")),
        lights_(options.get<double>("lb.example_lights")),
        light_rank_(options.get<double>("lb.light_rank")),
        visibility_rank_(options.get<double>("lb.visibility_rank")),
        photons_(options.get<double>("lb.photons")),
        bits_(options.get<double>("compression.bits")),
        channels_(figure(figures, "transfer", "channels",
                         figure(figures, "photon_transfer", "channels", 3.0))),
        rank_(figure(figures, "snapshot", "rank", 40.0) *
              rank_growth(options.get<double>("transport.tolerance"), figures)),
        transfer_rank_(
            figure(figures, "transfer", "rank", figure(figures, "photon_transfer", "rank", 40.0))),
        rounds_(figure(figures, "transfer", "rounds", 1.0)) {
    const std::size_t most =
        most_region_clusters(options, static_cast<std::size_t>(std::ceil(clusters_)));
    regions_ = std::ceil(clusters_ / static_cast<double>(most));
    // How much the clusters see of each other is not known yet: as much as a window may hold.
    const double window =
        regions_ > 1.0 ? std::min<double>(clusters_, most_window_clusters(most)) : clusters_;
    functions_ = light_rank_ * window;
    unknowns_ = rank_ * window;
  }

  [[nodiscard]] std::vector<StageWork> all() const {
    const double rays = n_ * directions_;
    const double rank = std::min({visibility_rank_, per_cluster_, directions_});
    const double small = std::min(per_cluster_, directions_);
    const double large = std::max(per_cluster_, directions_);
    const double examples = std::ceil(lights_ / 250.0);
    const double offered = kCandidatesPerRank * light_rank_;
    const double cluster_rays = 6.0 * rays / clusters_;
    std::vector<StageWork> work = {
        {"visibility", clusters_, 0, clusters_ * small * small * large + kProductsPerDepth * rays,
         clusters_ * (bits_ / 8.0 * rank + 2.0) * directions_ + bits_ / 8.0 * n_ * rank,
         cluster_rays + 16.0 * rays / clusters_},
        {"lights", examples, 0, lights_, 12.0 * lights_ + 500.0 * examples, 0},
        {"light_basis", clusters_, n_ * lights_,
         n_ * lights_ + 0.3 * rays + 0.01 * n_ * kEffectRows * std::min(lights_, kEffectRows),
         4.0 * offered * (2.0 * n_ + clusters_ * lights_),
         cluster_rays + 4.0 * per_cluster_ * (lights_ + kEffectRows)},
        {"light_functions", 1, 0, n_ * light_rank_,
         16.0 * n_ * light_rank_ + 4.0 * light_rank_ * clusters_ * lights_,
         40.0 * n_ * light_rank_},
        {"near", clusters_, 0, rays, std::sqrt(n_), cluster_rays}};
    if (regions_ > 1.0) {
      const double window = per_cluster_ * functions_;  // values of a window's light functions
      work.push_back({"reach", clusters_, 0, rays, 8.0 * clusters_ * clusters_, cluster_rays});
      work.push_back({"windows", 1, 0, n_, 4.0 * functions_ * regions_ / light_rank_, 24.0 * n_});
      work.push_back({"window_functions", regions_ + 1.0, 0, regions_ * window,
                      4.0 * regions_ * (window + functions_ * lights_) + 8.0 * n_ * light_rank_,
                      16.0 * n_ * light_rank_});
    }
    add_transport(work, rays, cluster_rays);
    return work;
  }

 private:
  void add_transport(std::vector<StageWork>& work, double rays, double cluster_rays) const {
    const double gathered = 4.0 * channels_ * per_cluster_ * functions_;
    const double snapshots = 4.0 * channels_ * per_cluster_ * unknowns_;
    const double bytes = bits_ / 8.0;
    const double compressed = bytes * transfer_rank_ * (n_ + clusters_ * channels_ * functions_);
    const double all_unknowns = rank_ * clusters_;
    const double probes = 16.0 * channels_ * n_;
    const double once = channels_ * (rays * light_rank_ + n_ * functions_ * kMixtures / 8.0);
    const double again = channels_ * (rays * rank_ + n_ * unknowns_ * rank_ / 4.0);
    const double held = per_cluster_ * unknowns_;  // values of a window's snapshots
    // Every later round has up to twice the rank of the one before, and squares count.
    const double r = rounds_;
    work.push_back(
        {"snapshot", r * clusters_, 0,
         r * (once + channels_ * n_ * kMixtures * std::min(per_cluster_, kMixtures) / 2.0),
         r * 4.0 * (rank_ * n_ + channels_ * all_unknowns * functions_),
         cluster_rays + 2.0 * gathered});
    work.push_back({"snapshot_functions", r * regions_, 0, r * regions_ * held,
                    r * regions_ * 4.0 * held, 8.0 * held});
    work.push_back({"galerkin", r * clusters_, 0, r * again,
                    r * 4.0 * channels_ * all_unknowns * unknowns_, cluster_rays + snapshots});
    const double solves = r * channels_ * regions_;
    work.push_back(
        {"solve", solves, 0, solves * unknowns_ * unknowns_ * (unknowns_ / 3.0 + functions_),
         solves * 4.0 * unknowns_ * functions_, 16.0 * unknowns_ * (unknowns_ + functions_)});
    work.push_back({"transfer", r * clusters_, 0,
                    r * (once + again + channels_ * n_ * kMixtures * kMixtures / 2.0),
                    r * (compressed + probes), cluster_rays + gathered + snapshots});
    work.push_back(
        {"residual", r * clusters_, 0, r * rays, r * 728.0 * clusters_, cluster_rays + probes});
    work.push_back({"photons", clusters_, 0, photons_, 4.0 * channels_ * n_ * functions_,
                    4.0 * channels_ * n_ * light_rank_});
    work.push_back(
        {"photon_transfer", clusters_, 0, channels_ * n_ * functions_, compressed, 3.0 * gathered});
  }

  double n_, clusters_, per_cluster_, directions_, lights_, light_rank_, visibility_rank_, photons_,
      bits_, channels_, rank_, transfer_rank_, rounds_;
  double regions_ = 1.0;
  double functions_ = 0.0;  // of a window
  double unknowns_ = 0.0;   // of a window
};

}  // namespace

std::vector<StageWork> stage_work(const BakeSize& size, const OptionValues& options,
                                  const StageFigures& figures) {
  std::vector<StageWork> all = sampling_and_rays_work(size, options);
  const std::vector<StageWork> own = Work(size, options, figures).all();
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

}  // namespace prt::lb
