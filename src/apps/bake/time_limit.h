// A time limit as the input: after the coarsest level of effort a bake goes on with the finest that
// is likely to be done in what is left, and then again while another fits. Which level that is
// hangs on clocks, so every choice is kept in the manifest, and a resume repeats none.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/bake/bake.h"
#include "apps/bake/history.h"
#include "apps/bake/made_bake.h"
#include "store/bake_folder.h"

namespace prt {

/// Option time_limit, s; nothing: there is none.
std::optional<double> time_limit_of(const OptionValues& options);

/// Wall seconds that a bake with `options` would take on `threads` threads in all, from what `made`
/// took. Counted on samples.count; what work between stages takes is not in it.
double expected_seconds(const BakeProgram& program, const Method& method, const MadeBake& made,
                        const OptionValues& options, int threads);

struct FittingLevel {
  int level = 0;         ///< `after` itself: none fits
  double seconds = 0.0;  ///< it takes; where none fits, the one after `after`
};
/// The finest level that fits into `left` seconds with some to spare, of those after `after`;
/// `seconds`: what they take, in order.
FittingLevel finest_fitting(int after, const std::vector<double>& seconds, double left);

/// A level that is done, when the next is to be chosen.
struct LevelDone {
  int level = 0;
  const OptionValues& options;  ///< its own
  std::string prefix;           ///< of the ids of its tasks
  /// Figures of a finished task's artifact, empty where it cannot be read.
  std::function<nlohmann::json(const std::string& task)> figures;
};

class TimedLevels {
 public:
  struct Budget {
    double limit = 0.0;  ///< s
    double began = 0.0;  ///< when this run began, by BakeProgram::clock
    int threads = 1;     ///< of all ranks
  };
  TimedLevels(const BakeProgram& program, const Method& method, const OptionValues& options,
              const Scene& scene, const Budget& budget, const History& history, BakeFolder& folder);

  /// The level after `done`, up to `most`: as chosen before, or chosen now and written down.
  LevelChoice choose(const LevelDone& done, int most);

 private:
  [[nodiscard]] LevelChoice choose_now(const LevelDone& done, int most) const;
  [[nodiscard]] std::vector<double> seconds_after(const LevelDone& done, int most,
                                                  double took) const;

  const BakeProgram& program_;
  const Method& method_;
  const OptionValues& options_;
  Budget budget_;
  const History& history_;
  BakeFolder& folder_;
  Digest bake_;
  std::vector<LevelChoice> choices_;  // of this very bake
};

/// For the report: {seconds, level, predicted_seconds, next_seconds, levels}; `levels` as
/// describe_level has it, `choices` those between and after them.
nlohmann::json describe_time_limit(double limit, nlohmann::json levels,
                                   const std::vector<LevelChoice>& choices);

/// Adds what became of it, after so many seconds: used_seconds, met and each level's seconds.
void add_used_seconds(nlohmann::json& time_limit, double used);

}  // namespace prt
