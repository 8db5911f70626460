#include "apps/bake/time_limit.h"

#include <algorithm>

#include "apps/bake/accuracy.h"
#include "base/log.h"

namespace prt {

namespace {

// What a level may take longer than foretold and still be chosen: predictions from the level before
// were at most so far below what then happened (results/error.md, time as the input).
constexpr double kMargin = 1.25;

/// Of all that decides which levels there are, what they take and how fine they have to be.
Digest settings_digest(const Method& method, const OptionValues& options, const Scene& scene) {
  Hasher hasher;
  hasher.add(method.name());
  for (const Digest& part : {scene.geometry_hash, scene.materials_hash, scene.lights_hash}) {
    hasher.add(part.hex());
  }
  hasher.add(options.at("time_limit").dump());
  for (int level = 0; level < method.effort_levels(); ++level) {
    hasher.add(nlohmann::json(options_of_results(options_at(method, options, level))).dump());
  }
  return hasher.digest();
}

}  // namespace

std::optional<double> time_limit_of(const OptionValues& options) {
  if (!options.is_set("time_limit")) return std::nullopt;
  return options.get<double>("time_limit");
}

double expected_seconds(const BakeProgram& program, const Method& method, const MadeBake& made,
                        const OptionValues& options, int threads) {
  const BakeSize size = size_with(options, options.get<double>("samples.count"));
  return seconds_on(threads, scale_bake(program, method, made, size, options));
}

FittingLevel finest_fitting(int after, const std::vector<double>& seconds, double left) {
  if (seconds.empty()) return {after, 0.0};
  for (int level = after + static_cast<int>(seconds.size()); level > after; --level) {
    const double takes = seconds[static_cast<std::size_t>(level - after - 1)];
    if (takes * kMargin <= left) return {level, takes};
  }
  return {after, seconds.front()};
}

TimedLevels::TimedLevels(const BakeProgram& program, const Method& method,
                         const OptionValues& options, const Scene& scene, const Budget& budget,
                         const History& history, BakeFolder& folder)
    : program_(program),
      method_(method),
      options_(options),
      budget_(budget),
      history_(history),
      folder_(folder),
      bake_(settings_digest(method, options, scene)) {
  std::ranges::copy_if(folder.found().choices, std::back_inserter(choices_),
                       [&](const LevelChoice& choice) { return choice.bake == bake_; });
}

LevelChoice TimedLevels::choose(const LevelDone& done, int most) {
  for (const LevelChoice& choice : choices_) {
    if (choice.after == done.level) return choice;
  }
  const LevelChoice choice = choose_now(done, most);
  folder_.manifest().append(choice);
  choices_.push_back(choice);
  const double left = budget_.limit - choice.used;
  if (choice.level == done.level) {
    log::info(
        "time limit: level {} is the last; the next would take about {:.1f} s, {:.1f} s are left",
        done.level, choice.predicted, left);
  } else {
    log::info("time limit: level {} after level {}, about {:.1f} s; {:.1f} s are left",
              choice.level, done.level, choice.predicted, left);
  }
  return choice;
}

LevelChoice TimedLevels::choose_now(const LevelDone& done, int most) const {
  const double used = program_.clock() - budget_.began + history_.earlier_seconds();
  double before = 0.0;  // when the level began
  for (const LevelChoice& choice : choices_) {
    if (choice.level == done.level) before = choice.used;
  }
  const double took = std::max(0.0, used - before);
  const FittingLevel next =
      finest_fitting(done.level, seconds_after(done, most, took), budget_.limit - used);
  return {bake_, done.level, next.level, next.seconds, used};
}

std::vector<double> TimedLevels::seconds_after(const LevelDone& done, int most, double took) const {
  MadeBake made;
  made.options = done.options;
  made.size = size_with(made.options, made.options.get<double>("samples.count"));
  for (const TaskHistory& task : history_.tasks()) {
    if (level_of(task.task) != done.prefix) continue;
    made.stages.add(task.task, task.stage, task.cost.seconds, static_cast<double>(task.cost.bytes),
                    task.made ? task.figures : done.figures(task.task));
  }
  const auto expected = [&](const OptionValues& options) {
    return expected_seconds(program_, method_, made, options, budget_.threads);
  };
  const double itself = expected(made.options);
  // Found without a word of what it took: one step on is all that can be answered for.
  if (itself <= 0.0) return {0.0};
  // After an interruption the clock knows of finished tasks alone, and may have seen less than
  // them.
  took = std::max(took, itself);
  std::vector<double> seconds;
  for (int level = done.level + 1; level <= most; ++level) {
    seconds.push_back(took * expected(options_at(method_, options_, level)) / itself);
  }
  return seconds;
}

nlohmann::json describe_time_limit(double limit, nlohmann::json levels,
                                   const std::vector<LevelChoice>& choices) {
  nlohmann::json predicted = nullptr;
  nlohmann::json next = nullptr;
  levels[0]["predicted_seconds"] = nullptr;
  levels[0]["began_seconds"] = 0.0;
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const LevelChoice& choice = choices[i - 1];
    levels[i]["predicted_seconds"] = choice.predicted;
    levels[i]["began_seconds"] = choice.used;
    predicted = choice.used + choice.predicted;
  }
  if (choices.size() == levels.size()) next = choices.back().predicted;
  const nlohmann::json level = levels.back()["level"];
  return {{"seconds", limit},
          {"level", level},
          {"predicted_seconds", predicted},
          {"next_seconds", next},
          {"levels", std::move(levels)}};
}

void add_used_seconds(nlohmann::json& time_limit, double used) {
  time_limit["used_seconds"] = used;
  time_limit["met"] = used <= time_limit["seconds"].get<double>();
  double end = used;
  nlohmann::json& levels = time_limit["levels"];
  for (std::size_t i = levels.size(); i-- > 0;) {
    const auto began = levels[i]["began_seconds"].get<double>();
    levels[i]["seconds"] = end - began;
    levels[i].erase("began_seconds");
    end = began;
  }
}

}  // namespace prt
