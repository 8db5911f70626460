#include "scaling/measured_bake.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "methods/common/sampling.h"
#include "methods/lb/scene_part.h"
#include "store/artifact_store.h"
#include "store/file_system.h"
#include "store/manifest.h"

namespace prt::scaling {

namespace {

using nlohmann::json;
using Entries = std::vector<ManifestEntry>;

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

std::ifstream open(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  return in;
}

/// "rays/0007": 7; of "solve" none.
std::optional<std::size_t> number_of(const std::string& task) {
  const std::size_t slash = task.find('/');
  if (slash == std::string::npos) return std::nullopt;
  return std::stoul(task.substr(slash + 1));
}

KindFigures figures_of(const Entries& lines, const std::string& kind,
                       const std::vector<double>& sizes) {
  std::vector<double> seconds, bytes, seconds_per_sample, bytes_per_sample;
  for (const ManifestEntry& line : lines) {
    // "transfer-2/0007" is of a second round, whose tasks are larger.
    if (line.kind != kind || line.task.substr(0, line.task.find('/')) != kind) continue;
    seconds.push_back(line.cpu_seconds);
    bytes.push_back(static_cast<double>(line.bytes));
    const auto number = number_of(line.task);
    if (!number || *number >= sizes.size()) continue;
    seconds_per_sample.push_back(line.cpu_seconds / sizes[*number]);
    bytes_per_sample.push_back(bytes.back() / sizes[*number]);
  }
  KindFigures figures{median(seconds), median(bytes), 0.0, 0.0, seconds.size()};
  if (seconds.size() == sizes.size()) {
    figures.seconds_per_sample = median(seconds_per_sample);
    figures.bytes_per_sample = median(bytes_per_sample);
  }
  return figures;
}

}  // namespace

MeasuredBake read_bake(const std::filesystem::path& folder) {
  PosixFileSystem fs;
  const ArtifactStore store(fs, folder);
  const Entries lines = read_manifest(fs, folder / kManifestName).entries;
  MeasuredBake bake;
  double in_tasks = 0.0;
  double cpu = 0.0;
  for (const ManifestEntry& line : lines) {
    in_tasks += line.seconds;
    cpu += line.cpu_seconds;
    bake.task_seconds[line.task] = line.seconds;
    const auto artifact = [&] { return store.read(line.kind, line.key, line.content); };
    if (line.task == kSamplesTask) {
      const auto samples = artifact();
      bake.spacing = samples->attribute<double>("spacing");
      const auto begin = samples->values<std::uint32_t>("cluster_begin");
      bake.samples = begin.back();
      for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
        bake.sizes.push_back(begin[c + 1] - begin[c]);
      }
      bake.centres = cluster_centres(samples->points("position"), begin);
    } else if (line.task == lb::kWindowsTask) {
      bake.regions = lb::get_regions(*artifact());
    }
  }
  if (bake.sizes.empty()) throw std::runtime_error(folder.string() + ": has no samples");
  const json report = json::parse(open(folder / "report.json"));
  for (const auto& [key, value] : report.at("options").items()) bake.options.set(key, value);
  bake.package_bytes = report.at("package_bytes");
  bake.wall_seconds = report.at("bake_seconds");
  bake.ranks = report.at("this_run").at("ranks");
  // One thread: what is not in a task is start-up, planning and the package.
  bake.outside_tasks = std::max(0.0, bake.wall_seconds - in_tasks) * cpu / in_tasks;
  bake.package_seconds =
      std::min(bake.outside_tasks, report.at("this_run").at("package_seconds").get<double>());
  for (const ManifestEntry& line : lines) {
    if (bake.kinds.contains(line.kind)) continue;
    bake.kinds[line.kind] = figures_of(lines, line.kind, bake.sizes);
  }
  return bake;
}

Law fit_law(const std::vector<std::pair<double, double>>& points) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [x, value] : points) {
    n += 1;
    sx += x;
    sy += value;
    sxx += x * x;
    sxy += x * value;
  }
  Law law{sy / n, 0.0};
  const double determinant = n * sxx - sx * sx;
  if (determinant <= 0.0) return law;  // one bake: no growth to be seen
  law.growing = std::max(0.0, (n * sxy - sx * sy) / determinant);
  law.fixed = (sy - law.growing * sx) / n;
  if (law.fixed < 0.0) law = {0.0, sxy / sxx};
  return law;
}

}  // namespace prt::scaling
