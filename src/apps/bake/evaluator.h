// How a bake measures its own error: extra tasks beside the method's.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "methods/method.h"

namespace prt {

class BakeErrorMeter {
 public:
  virtual ~BakeErrorMeter() = default;
  /// Its tasks, given what the method has planned so far. Complete only if the method's plan is.
  [[nodiscard]] virtual Plan plan(const OptionValues& options, const Plan& method_plan) const = 0;
  [[nodiscard]] virtual std::vector<std::string> kinds() const = 0;
  [[nodiscard]] virtual Artifact run(const TaskSpec& task, const TaskReader& reader,
                                     const Method& method, const OptionValues& options) const = 0;
  /// As Method::work, of its own stages.
  [[nodiscard]] virtual std::vector<StageWork> work(const BakeSize& size,
                                                    const OptionValues& options) const = 0;
  /// The error of the bake, as it goes into package and report, from the artifact of one of
  /// Plan::results; what several of them say goes side by side. Positions in it are in the world of
  /// a scene of that origin.
  [[nodiscard]] virtual nlohmann::json error(const Artifact& result, const Vec3d& origin) const = 0;
};

}  // namespace prt
