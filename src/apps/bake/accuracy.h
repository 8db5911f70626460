// Accuracy as the input: a bake goes from one level of effort to the next until its own error, on
// test lights that no basis was made from, is below what was asked for.
#pragma once

#include <optional>

#include "methods/method.h"

namespace prt {

/// Options accuracy.*: the errors that a user asks for.
struct AccuracyGoal {
  std::optional<double> indirect;    ///< pooled relative RMS error of indirect light at samples
  std::optional<double> visibility;  ///< share of sample and light pairs judged wrongly

  explicit AccuracyGoal(const OptionValues& options);
  [[nodiscard]] bool wanted() const { return indirect || visibility; }

  /// How many times too large the error is, by the figure that is worst; at most 1: the goal is
  /// met. `error` is BakeErrorMeter::error. An error counts with its standard error on top, for
  /// other lights than the test lights are to meet the goal, too.
  [[nodiscard]] double excess(const nlohmann::json& error) const;
};

/// The options of a level: the method's, and, where there is a goal, test lights and paths enough
/// to judge by it.
OptionValues options_at(const Method& method, const OptionValues& options, int level);

/// The next level after one that missed its goal by `excess`: as many steps on as the error is
/// likely to need, the last at most.
int next_level(const Method& method, int level, double excess);

/// {indirect, visibility}: those that are asked for.
nlohmann::json describe_goal(const AccuracyGoal& goal);

/// One line per level in the report: level, samples and errors. `error`: null where none was
/// measured.
nlohmann::json describe_level(int level, const OptionValues& options, const nlohmann::json& error);

}  // namespace prt
