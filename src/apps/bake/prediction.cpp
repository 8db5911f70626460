#include "apps/bake/prediction.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/bake/history.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "methods/common/sampling.h"
#include "store/hdf5_image.h"

namespace prt {

namespace {

using Results = std::map<std::string, std::shared_ptr<const Artifact>>;

/// Rays of the small bake: about half a second of them.
constexpr double kPilotRays = 1.5e6;
constexpr double kFewestSamples = 400.0;
constexpr double kMostSamples = 3000.0;
/// Clusters of the small bake; and test points of its one test light.
constexpr double kPilotClusters = 6.0;
constexpr std::size_t kPilotPoints = 100;

OptionValues pilot_options(const OptionValues& wanted) {
  OptionValues options = wanted;
  const auto limit = [&](const std::string& key, double most) {
    if (options.get<double>(key) > most) options.set(key, static_cast<std::size_t>(most));
  };
  double samples =
      std::clamp(kPilotRays / options.get<double>("rays.directions"), kFewestSamples, kMostSamples);
  if (options.is_set("samples.count")) {
    samples = std::min(samples, options.get<double>("samples.count"));
  }
  options.set("samples.spacing", nullptr);
  options.set("samples.count", static_cast<std::size_t>(samples));
  limit("samples.cluster_size", std::ceil(samples / kPilotClusters));
  limit("evaluate.lights", 1);
  limit("evaluate.points", kPilotPoints);
  return options;
}

/// A bake whose artifacts stay in memory; one thread.
class Pilot : public PlanInputs {
 public:
  Pilot(const BakeProgram& program, const Method& method, OptionValues options, const Scene& scene,
        const std::string& isa, const std::atomic<bool>& stop)
      : program_(program),
        method_(method),
        options_(std::move(options)),
        scene_(scene),
        caster_(program.make_ray_caster(scene, isa)),
        stop_(stop) {}

  /// False if it was stopped.
  bool run() {
    for (;;) {
      plan_ = method_.plan(*this);
      Plan judged;
      if (program_.evaluator) judged = program_.evaluator->plan(options_, plan_);
      std::vector<TaskSpec> tasks = plan_.tasks;
      tasks.insert(tasks.end(), judged.tasks.begin(), judged.tasks.end());
      bool ran = false;
      for (const TaskSpec& task : tasks) {
        if (stop_) return false;
        if (results_.contains(task.id)) continue;
        make(task);
        ran = true;
      }
      if (plan_.complete) return true;
      if (!ran) throw std::logic_error("a plan that is not complete has no task to run");
    }
  }

  [[nodiscard]] const Scene& scene() const override { return scene_; }
  [[nodiscard]] const OptionValues& options() const override { return options_; }
  [[nodiscard]] std::shared_ptr<const Artifact> result(const std::string& id) const override {
    const auto found = results_.find(id);
    return found == results_.end() ? nullptr : found->second;
  }
  [[nodiscard]] const MadeStages& stages() const { return stages_; }
  [[nodiscard]] const std::vector<LeftOut>& left_out() const { return plan_.left_out; }

  [[nodiscard]] nlohmann::json survey() const {
    std::vector<nlohmann::json> rays;
    for (const auto& [id, artifact] : results_) {
      if (id.starts_with("rays/")) rays.push_back(figures_of(*artifact));
    }
    const auto samples = result(kSamplesTask);
    const auto albedo = result(kAlbedoTask);
    if (!samples || !albedo) return nullptr;
    return survey_scene(scene_, rays, *samples, *albedo);
  }

 private:
  class Reader : public TaskReader {
   public:
    Reader(Pilot& pilot, const TaskSpec& task) : pilot_(pilot), task_(task) {}
    [[nodiscard]] const Scene& scene() const override { return pilot_.scene_; }
    [[nodiscard]] const RayCaster& ray_caster() const override { return *pilot_.caster_; }
    [[nodiscard]] std::shared_ptr<const Artifact> input(std::size_t i) const override {
      return pilot_.results_.at(task_.inputs.at(i));
    }
    [[nodiscard]] Digest input_content(std::size_t i) const override {
      return hash_text(task_.inputs.at(i));
    }
    [[nodiscard]] Memo& memo() const override { return pilot_.memo_; }
    [[nodiscard]] bool stop_requested() const override { return pilot_.stop_; }

   private:
    Pilot& pilot_;
    const TaskSpec& task_;
  };

  void make(const TaskSpec& task) {
    const double began = thread_cpu_seconds();
    const Reader reader(*this, task);
    const BakeErrorMeter* meter = program_.evaluator.get();
    const bool judges = meter != nullptr && std::ranges::count(meter->kinds(), task.kind) > 0;
    auto artifact = std::make_shared<Artifact>(judges ? meter->run(task, reader, method_, options_)
                                                      : method_.run(task, reader));
    // As a bake does: file, content, and read again to verify.
    const auto file = to_hdf5(*artifact, {task.kind, hash_text(task.id), task.version, ""});
    (void)from_hdf5(file);
    stages_.add(task.id, task.kind, thread_cpu_seconds() - began, static_cast<double>(file.size()),
                figures_of(*artifact));
    results_[task.id] = std::move(artifact);
  }

  const BakeProgram& program_;
  const Method& method_;
  OptionValues options_;
  const Scene& scene_;
  std::unique_ptr<RayCaster> caster_;
  const std::atomic<bool>& stop_;
  Memo memo_;
  Plan plan_;
  Results results_;
  MadeStages stages_;
};

}  // namespace

StagePrediction BakePrediction::total() const {
  StagePrediction sum;
  sum.stage = "all";
  for (const StagePrediction& s : stages) {
    sum.tasks += s.tasks;
    sum.rays += s.rays;
    sum.seconds += s.seconds;
    sum.bytes += s.bytes;
    sum.memory = std::max(sum.memory, s.memory);
  }
  return sum;
}

PredictionBeside::PredictionBeside(Predict predict)
    : made_(std::async(std::launch::async, [this, predict = std::move(predict)] {
        try {
          return predict(stop_);
        } catch (const std::exception& e) {
          // The bake itself will say what is wrong.
          log::debug("nothing is predicted: {}", e.what());
          return std::optional<BakePrediction>();
        }
      })) {}

const BakePrediction* PredictionBeside::get() {
  if (made_.valid()) prediction_ = made_.get();
  return prediction_ ? &*prediction_ : nullptr;
}

nlohmann::json survey_scene(const Scene& scene, const std::vector<nlohmann::json>& rays,
                            const Artifact& samples, const Artifact& albedo) {
  double count = 0.0, back = 0.0, all = 0.0, escaped = 0.0, lost = 0.0, most = 0.0, least = 1.0;
  for (const nlohmann::json& cluster : rays) {
    const double n = cluster.value("samples", 0.0);
    const double escaped_share = cluster.value("escaped_share", 0.0);
    count += n;
    all += n * cluster.value("directions", 0.0);
    back += cluster.value("back_hits", 0.0);
    escaped += n * escaped_share;
    lost += n * cluster.value("lost_share", 0.0);
    most = std::max(most, 1.0 - escaped_share);
    least = std::min(least, 1.0 - escaped_share);
  }
  const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };
  const MatrixF values = albedo.matrix("albedo");
  const auto areas = samples.values<float>("area");
  double reflected = 0.0, area = 0.0;
  for (Eigen::Index s = 0; s < values.rows(); ++s) {
    reflected += areas[static_cast<std::size_t>(s)] * values.row(s).mean();
    area += areas[static_cast<std::size_t>(s)];
  }
  return {{"rays", all},
          {"back_hit_share", share(back, all)},
          {"escaped_share", share(escaped, count)},
          {"lost_share", share(lost, count)},
          {"hit_share_of_cluster", {{"least", std::min(least, most)}, {"most", most}}},
          {"mean_albedo", share(reflected, area)},
          {"largest_albedo", albedo.attribute<double>("largest")},
          {"colour_spread", albedo.attribute<double>("colour_spread")},
          {"reachable_area", area},
          {"diagonal", scene.diagonal()}};
}

std::optional<BakePrediction> predict_bake(const BakeProgram& program, const Method& method,
                                           const OptionValues& options, const Scene& scene,
                                           const std::string& isa, const std::atomic<bool>& stop) {
  if (method.work({1.0, 1.0}, options, {}).empty()) return std::nullopt;
  const double began = thread_cpu_seconds();
  const OptionValues small = pilot_options(options);
  Pilot pilot(program, method, small, scene, isa, stop);
  try {
    if (!pilot.run()) return std::nullopt;
  } catch (const Interrupted&) {
    return std::nullopt;
  }
  const auto samples = pilot.result(kSamplesTask);
  if (!samples) return std::nullopt;  // a method without them: nothing to scale by
  BakePrediction prediction;
  const BakeSize size =
      size_with(options, expected_samples(options, samples->attribute<double>("area")));
  prediction.samples = size.samples;
  prediction.clusters = size.clusters;
  prediction.made = {
      pilot.stages(),
      {samples->attribute<double>("samples"), samples->attribute<double>("clusters")},
      small};
  prediction.stages = scale_bake(program, method, prediction.made, size, options);
  prediction.left_out = pilot.left_out();
  prediction.survey = pilot.survey();
  prediction.pilot_seconds = thread_cpu_seconds() - began;
  return prediction;
}

}  // namespace prt
