// What a bake will take, from a small bake of the same scene in memory.
#pragma once

#include <atomic>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "apps/bake/made_bake.h"

namespace prt {

struct BakePrediction {
  std::vector<StagePrediction> stages;  ///< in the order of the bake
  MadeBake made;                        ///< the small bake
  std::vector<LeftOut> left_out;        ///< by the small bake
  nlohmann::json survey;                ///< of the scene (survey_scene), from the small bake
  double samples = 0.0;
  double clusters = 0.0;
  double pilot_seconds = 0.0;  ///< of CPU that the small bake took

  [[nodiscard]] StagePrediction total() const;  ///< memory: of the largest task
};

/// Bakes a few hundred samples in memory, about a second, and scales what each stage took by
/// Method::work. Writes nothing. Nothing where the method predicts nothing, or `stop` is set.
/// Throws UserError as a bake would.
std::optional<BakePrediction> predict_bake(const BakeProgram& program, const Method& method,
                                           const OptionValues& options, const Scene& scene,
                                           const std::string& isa, const std::atomic<bool>& stop);

/// A prediction that is made beside the bake, on a thread of its own: nobody waits for it before
/// the report.
class PredictionBeside {
 public:
  using Predict = std::function<std::optional<BakePrediction>(const std::atomic<bool>& stop)>;

  explicit PredictionBeside(Predict predict);
  /// Gives up a prediction that is still being made.
  ~PredictionBeside() { stop_ = true; }
  PredictionBeside(const PredictionBeside&) = delete;
  PredictionBeside& operator=(const PredictionBeside&) = delete;

  /// Waits until it is made; null where nothing could be predicted.
  const BakePrediction* get();

 private:
  std::atomic<bool> stop_ = false;
  std::optional<BakePrediction> prediction_;
  std::future<std::optional<BakePrediction>> made_;  // last: goes first, and waits for its thread
};

/// Figures of a scene that decide what a bake of it needs, from what its ray and albedo tasks said.
nlohmann::json survey_scene(const Scene& scene, const std::vector<nlohmann::json>& rays,
                            const Artifact& samples, const Artifact& albedo);

}  // namespace prt
