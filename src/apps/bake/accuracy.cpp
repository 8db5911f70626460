#include "apps/bake/accuracy.h"

#include <algorithm>
#include <cmath>

namespace prt {

namespace {

constexpr int kLeastLights = 48;
// Paths per point that keep the references' noise near a tenth of the goal; it falls with their
// root.
constexpr double kPathsAtTenPerCent = 32.0;
constexpr int kMostPaths = 1024;
// What a level leaves of the error of the one before, at best: steps are rather too short than too
// long, for a level too many costs more than all before it.
constexpr double kBestStep = 0.6;

std::optional<double> goal_of(const OptionValues& options, const std::string& key) {
  if (!options.is_set(key)) return std::nullopt;
  return options.get<double>(key);
}

double with_error(const nlohmann::json& figures) {
  return figures["rel_rmse"].get<double>() +
         std::hypot(figures["standard_error"].get<double>(), figures["light_error"].get<double>());
}

}  // namespace

AccuracyGoal::AccuracyGoal(const OptionValues& options)
    : indirect(goal_of(options, "accuracy.indirect")),
      visibility(goal_of(options, "accuracy.visibility")) {}

double AccuracyGoal::excess(const nlohmann::json& error) const {
  double worst = 0.0;
  // A figure that is null has nothing to be compared with: that goal cannot be missed.
  if (indirect && error["indirect"]["rel_rmse"].is_number()) {
    worst = with_error(error["indirect"]) / *indirect;
  }
  if (visibility) worst = std::max(worst, error["visibility_error"].get<double>() / *visibility);
  return worst;
}

OptionValues options_at(const Method& method, const OptionValues& options, int level) {
  OptionValues at = method.with_effort(options, level);
  const AccuracyGoal goal(options);
  if (!goal.wanted()) return at;
  at.set("evaluate.lights", std::max(kLeastLights, options.get<int>("evaluate.lights")));
  if (options.get<int>("evaluate.points") == 0) at.set("evaluate.points", 1000);
  const double times = goal.indirect ? 0.1 / *goal.indirect : 1.0;
  const double paths = std::min<double>(kMostPaths, kPathsAtTenPerCent * times * times);
  at.set("evaluate.spp", std::max(static_cast<int>(paths), options.get<int>("evaluate.spp")));
  return at;
}

int next_level(const Method& method, int level, double excess) {
  const double steps = std::floor(std::log(excess) / -std::log(kBestStep));
  const int wanted = level + std::max(1, static_cast<int>(std::min(steps, 100.0)));
  return std::min(wanted, method.effort_levels() - 1);
}

nlohmann::json describe_goal(const AccuracyGoal& goal) {
  nlohmann::json all = nlohmann::json::object();
  if (goal.indirect) all["indirect"] = *goal.indirect;
  if (goal.visibility) all["visibility"] = *goal.visibility;
  return all;
}

nlohmann::json describe_level(int level, const OptionValues& options, const nlohmann::json& error) {
  nlohmann::json line = {{"level", level}, {"samples", options.at("samples.count")}};
  const bool judged = error.is_object();
  const nlohmann::json indirect = judged ? error["indirect"] : nlohmann::json::object();
  line["indirect"] = indirect.value("rel_rmse", nlohmann::json());
  for (const char* noise : {"standard_error", "light_error"}) {
    line[noise] = indirect.value(noise, nlohmann::json());
  }
  line["visibility"] = judged ? error["visibility_error"] : nlohmann::json();
  return line;
}

}  // namespace prt
