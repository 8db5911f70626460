// What the stages of a finished bake took, and what those of another bake of the scene would take.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "apps/bake/bake.h"

namespace prt {

struct StagePrediction {
  std::string stage;
  double tasks = 0.0;
  double rays = 0.0;
  double seconds = 0.0;  ///< on one core
  double bytes = 0.0;    ///< of all its artifacts
  double memory = 0.0;   ///< that one task holds, bytes
};

/// Tasks that were made, summed up by stage.
class MadeStages {
 public:
  /// `figures`: the numbers among the artifact's attributes.
  void add(const std::string& task, const std::string& stage, double seconds, double bytes,
           const nlohmann::json& figures);
  /// Their means, and of each stage `tasks` and `rounds`.
  [[nodiscard]] StageFigures figures() const;
  [[nodiscard]] double seconds(const std::string& stage) const { return sums_.at(stage).seconds; }
  [[nodiscard]] double bytes(const std::string& stage) const { return sums_.at(stage).bytes; }
  [[nodiscard]] const std::vector<std::string>& order() const { return order_; }

 private:
  struct Sum {
    double seconds = 0.0;
    double bytes = 0.0;
    double tasks = 0.0;
    std::set<std::string> rounds;           ///< beginnings of ids: "transfer1" of "transfer1/0007"
    std::map<std::string, double> figures;  ///< sums over tasks
  };
  std::vector<std::string> order_;
  std::map<std::string, Sum> sums_;
};

/// A bake that was made.
struct MadeBake {
  MadeStages stages;
  BakeSize size;
  OptionValues options;
};

/// So many samples, and the clusters that `options` make of them.
BakeSize size_with(const OptionValues& options, double samples);

/// What a bake of that size with `options` would take, from what `made` took and Method::work.
/// Stages that no work is told of are left out.
std::vector<StagePrediction> scale_bake(const BakeProgram& program, const Method& method,
                                        const MadeBake& made, const BakeSize& size,
                                        const OptionValues& options);

/// Seconds of wall time, were the stages made one after the other on `threads` threads: a stage
/// of few tasks keeps only so many busy.
double seconds_on(int threads, const std::vector<StagePrediction>& stages);

}  // namespace prt
