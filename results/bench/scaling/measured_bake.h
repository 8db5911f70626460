// What the tasks of finished bakes took, by kind, and how that grows with the scene.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "domains/windows.h"
#include "methods/options.h"

namespace prt::scaling {

/// CPU seconds and bytes of the tasks of one kind. Medians: the machine that baked was shared, and
/// single tasks are off by a factor of three.
struct KindFigures {
  double seconds = 0.0;  ///< per task
  double bytes = 0.0;    ///< of its artifact
  /// The same per sample of the task's cluster; zero where tasks are not per cluster.
  double seconds_per_sample = 0.0;
  double bytes_per_sample = 0.0;
  std::size_t tasks = 0;
};

struct MeasuredBake {
  OptionValues options;
  std::vector<double> sizes;  ///< samples of each cluster
  double samples = 0.0;
  double spacing = 0.0;         ///< of the samples, m
  std::vector<Region> regions;  ///< empty: the scene was solved for as a whole
  std::vector<Vec3f> centres;   ///< of the clusters
  double package_bytes = 0.0;
  /// Seconds of start-up, planning and writing the results: wall time, times the share of a core
  /// that the tasks had meanwhile.
  double outside_tasks = 0.0;
  double package_seconds = 0.0;  ///< of those, for the package
  double wall_seconds = 0.0;     ///< of the bake
  int ranks = 1;
  std::map<std::string, double> task_seconds;  ///< wall seconds by task id
  std::map<std::string, KindFigures> kinds;
};

/// Reads report.json, manifest.log and what the planner reads. Throws std::exception naming the
/// file.
MeasuredBake read_bake(const std::filesystem::path& folder);

/// value = fixed + growing · size: seconds or bytes per sample of a cluster over the clusters that
/// the task's result may refer to, or seconds over bytes.
struct Law {
  double fixed = 0.0;
  double growing = 0.0;
  [[nodiscard]] double at(double size) const { return fixed + growing * size; }
};

/// Least squares, neither below zero.
Law fit_law(const std::vector<std::pair<double, double>>& size_and_value);

}  // namespace prt::scaling
