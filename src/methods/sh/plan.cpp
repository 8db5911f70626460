#include "methods/sh/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "bases/spherical_harmonics.h"
#include "methods/common/inputs.h"
#include "methods/common/rays.h"
#include "methods/common/sampling.h"

namespace prt::sh {

namespace {

// Less of every hemisphere than this is open: as much as rays may lose (design: the physics).
constexpr double kOpenShare = 1e-5;
// Bounces that are computed before it is asked whether they are enough.
constexpr int kFirstBounces = 2;

class Planner {
 public:
  Planner(const PlanInputs& inputs, Plan& plan)
      : in_(inputs),
        options_(inputs.options()),
        transfer_(transfer_of(options_)),
        order_(options_.get<int>("sh.order")),
        plan_(plan) {}

  void run() {
    if (!plan_sampling(in_, plan_)) return;
    const auto samples = in_.result(kSamplesTask);
    begin_ = samples->vector<std::uint32_t>("cluster_begin");
    clusters_ = begin_.size() - 1;
    if (transfer_ == Transfer::kUnshadowed) {
      plan_.left_out.push_back({"rays of the sky's light", "sh.transfer is unshadowed"});
    } else {
      plan_rays(in_, plan_);
    }
    plan_direct();
    const auto open = open_share();
    if (!open) return;
    if (*open < kOpenShare) {
      plan_.left_out.push_back(
          {"environment layer",
           fmt::format("no cluster sees more than {:.1g} of the sky: none of its light gets in",
                       kOpenShare)});
      plan_.results = {kSamplesTask};
      plan_.complete = true;
      return;
    }
    plan_.plays_environment = true;
    if (transfer_ == Transfer::kInterreflected) {
      if (!plan_bounces()) return;
    }
    plan_factors();
  }

 private:
  [[nodiscard]] bool has_rays() const { return transfer_ != Transfer::kUnshadowed; }

  /// The largest share of a cluster's hemispheres that is open, once it is known of all.
  [[nodiscard]] std::optional<double> open_share() const {
    double most = 0.0;
    for (std::size_t c = 0; c < clusters_; ++c) {
      const auto direct = in_.result(numbered(kDirect, c));
      if (!direct) return std::nullopt;
      most = std::max(most, direct->attribute<double>("open_share"));
    }
    return most;
  }

  [[nodiscard]] TaskSpec make(const std::string& kind, const std::string& stage, std::size_t c,
                              double seconds_per_sample) const {
    TaskSpec spec;
    spec.id = numbered(stage, c);
    spec.kind = kind;
    spec.inputs = {kSamplesTask};
    spec.parameters = {{"cluster", c}, {"order", order_}};
    spec.cost = seconds_per_sample * (begin_[c + 1] - begin_[c]);
    spec.place = cluster_place(c);
    return spec;
  }

  void plan_direct() {
    for (std::size_t c = 0; c < clusters_; ++c) {
      TaskSpec spec = make(kDirect, kDirect, c, 3e-5);
      if (has_rays()) spec.inputs.push_back(numbered("rays", c));
      plan_.tasks.push_back(spec);
    }
  }

  static std::string bounce(int number) {
    return number == 0 ? kDirect : fmt::format("{}-{}", kBounce, number);
  }

  /// Σ area · |transfer|² of a stage, once it is done.
  [[nodiscard]] std::optional<double> squared_norm(const std::string& stage) const {
    double sum = 0.0;
    for (std::size_t c = 0; c < clusters_; ++c) {
      const auto part = in_.result(numbered(stage, c));
      if (!part) return std::nullopt;
      sum += part->attribute<double>("squared_norm");
    }
    return sum;
  }

  /// False while it is not known how many there are.
  bool plan_bounces() {
    const auto albedo = in_.result(kAlbedoTask);
    if (!albedo) return false;
    const bool black = albedo->attribute<double>("largest") <= 0.0;
    const bool counted = !options_.is_auto("transport.bounces");
    const int most = counted ? options_.get<int>("transport.bounces") : kMostBounces;
    if (black || most == 0) {
      plan_.left_out.push_back({"bounced light of the sky",
                                black ? "every surface is black" : "transport.bounces is 0"});
      return true;
    }
    channels_ = colour_channels(*albedo);
    if (counted) {
      plan_up_to(most);
      return true;
    }
    // A few at first; then as many more as it takes if each is as much of the one before as the
    // last was. Whoever waits for one bounce after the other waits for the slowest task of each.
    for (int wanted = kFirstBounces;;) {
      plan_up_to(wanted);
      const auto tail = tail_after(wanted);
      if (!tail) return false;
      const double tolerance = options_.get<double>("transport.tolerance");
      const bool enough = tail->share <= tolerance;
      if (enough || wanted == most) {
        say_what_is_missing(wanted, tail->share, enough);
        return true;
      }
      const double more = std::ceil(std::log(tolerance / tail->share) / std::log(tail->ratio));
      wanted = static_cast<int>(std::min<double>(most, wanted + std::max(1.0, more)));
    }
  }

  struct Tail {
    double ratio;  ///< of a bounce to the one before
    double share;  ///< of all later bounces in what those before bring
  };
  /// What comes after so many bounces, at least two, about: each brings as much of the one before
  /// as the last of them does.
  [[nodiscard]] std::optional<Tail> tail_after(int bounces) const {
    double before = 0.0, last = 0.0, total = 0.0;
    for (int b = 1; b <= bounces; ++b) {
      const auto squared = squared_norm(bounce(b));
      if (!squared) return std::nullopt;
      before = last;
      last = std::sqrt(*squared);
      total += last;
    }
    if (!(last > 0.0)) return Tail{0.5, 0.0};
    const double ratio = std::clamp(last / before, 1e-6, 1.0 - 1e-6);
    return Tail{ratio, last * ratio / (1.0 - ratio) / total};
  }

  void say_what_is_missing(int bounces, double share, bool enough) {
    std::string reason = fmt::format("it is {:.1e} of what they bring", share);
    if (!enough) {
      reason =
          fmt::format("no more are computed, though it is some {:.1e} of what they bring", share);
    }
    plan_.left_out.push_back({fmt::format("the sky's light after {} bounces", bounces), reason});
  }

  void plan_up_to(int number) {
    while (bounces_ < number) plan_bounce(++bounces_);
  }

  void plan_bounce(int number) {
    for (std::size_t c = 0; c < clusters_; ++c) {
      const auto direct = in_.result(numbered(kDirect, c));
      const auto senders = direct->vector<std::uint32_t>("reached");
      TaskSpec spec = make(kBounce, bounce(number), c, 4e-5 * channels_);
      append(spec.inputs, {kAlbedoTask, numbered("rays", c)});
      for (const std::uint32_t s : senders) spec.inputs.push_back(numbered(bounce(number - 1), s));
      spec.parameters["channels"] = channels_;
      spec.parameters["senders"] = senders;
      plan_.tasks.push_back(spec);
    }
  }

  void plan_factors() {
    plan_.complete = true;
    plan_.results = {kSamplesTask};
    for (std::size_t c = 0; c < clusters_; ++c) {
      TaskSpec spec = make(kTransfer, kTransfer, c, 1e-5);
      for (int b = 0; b <= bounces_; ++b) spec.inputs.push_back(numbered(bounce(b), c));
      spec.parameters["channels"] = channels_;
      spec.parameters["bits"] = options_.get<int>("compression.bits");
      spec.parameters["tolerance"] = options_.get<double>("compression.tolerance");
      spec.parameters["window"] = options_.get<double>("sh.window");
      plan_.results.push_back(spec.id);
      plan_.tasks.push_back(spec);
    }
  }

  static void append(std::vector<std::string>& ids, const std::vector<std::string>& more) {
    ids.insert(ids.end(), more.begin(), more.end());
  }

  const PlanInputs& in_;
  const OptionValues& options_;
  Transfer transfer_;
  int order_;
  Plan& plan_;
  std::size_t clusters_ = 0;
  std::vector<std::uint32_t> begin_;
  int channels_ = 1;
  int bounces_ = 0;
};

}  // namespace

Transfer transfer_of(const OptionValues& options) {
  const auto word = options.get<std::string>("sh.transfer");
  if (word == "unshadowed") return Transfer::kUnshadowed;
  return word == "shadowed" ? Transfer::kShadowed : Transfer::kInterreflected;
}

Plan make_plan(const PlanInputs& inputs) {
  Plan plan;
  Planner(inputs, plan).run();
  return plan;
}

}  // namespace prt::sh
