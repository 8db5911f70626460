#include "scaling/measured_bake.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace prt::scaling {

namespace {

using nlohmann::json;

// Each line of a manifest is a hash of 32 digits, a blank and a JSON record.
constexpr std::size_t kDigits = 33;
// The two numbers per ray of a rays artifact, 2016 rays a sample, hardly shrink on disk.
constexpr double kRayBytesPerSample = 6.0 * 2016;

struct Line {
  std::string id;
  std::string kind;
  std::size_t number;  ///< "rays/0007": 7
  double seconds, cpu_seconds, bytes;
};

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

std::vector<Line> read_lines(const std::filesystem::path& file) {
  std::vector<Line> lines;
  std::ifstream in = open(file);
  for (std::string text; std::getline(in, text);) {
    const json record = json::parse(text.substr(std::min(kDigits, text.size())), nullptr, false);
    if (!record.is_object() || !record.contains("task")) continue;
    const std::string id = record.at("task");
    const std::size_t slash = id.find('/');
    lines.push_back({id, record.at("kind"),
                     slash == std::string::npos ? 0 : std::stoul(id.substr(slash + 1)),
                     record.at("seconds"), record.at("cpu_seconds"), record.at("bytes")});
  }
  return lines;
}

KindFigures figures_of(const std::vector<Line>& lines, const std::string& kind,
                       const std::vector<double>& sizes) {
  std::vector<double> seconds, bytes, seconds_per_sample, bytes_per_sample;
  for (const Line& line : lines) {
    // "transfer-2/0007" is of a second round, whose tasks are larger.
    if (line.kind != kind || line.id.substr(0, line.id.find('/')) != kind) continue;
    seconds.push_back(line.cpu_seconds);
    bytes.push_back(line.bytes);
    if (line.number >= sizes.size()) continue;
    seconds_per_sample.push_back(line.cpu_seconds / sizes[line.number]);
    bytes_per_sample.push_back(line.bytes / sizes[line.number]);
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
  MeasuredBake bake;
  const json report = json::parse(open(folder / "report.json"));
  const std::vector<Line> lines = read_lines(folder / "manifest.log");
  double in_tasks = 0.0;
  for (const Line& line : lines) {
    in_tasks += line.seconds;
    bake.task_seconds[line.id] = line.seconds;
    if (line.kind != "rays") continue;
    if (line.number >= bake.sizes.size()) bake.sizes.resize(line.number + 1, 1.0);
    bake.sizes[line.number] = line.bytes / kRayBytesPerSample;
    bake.samples += bake.sizes[line.number];
  }
  if (bake.sizes.empty()) throw std::runtime_error(folder.string() + ": has no rays");
  bake.package_bytes = report.at("package_bytes");
  bake.wall_seconds = report.at("bake_seconds");
  bake.ranks = report.at("this_run").at("ranks");
  // One thread: what is not in a task is start-up, planning and the package.
  bake.outside_tasks = std::max(0.0, bake.wall_seconds - in_tasks);
  for (const Line& line : lines) {
    if (bake.kinds.contains(line.kind)) continue;
    bake.kinds[line.kind] = figures_of(lines, line.kind, bake.sizes);
  }
  return bake;
}

double Law::at(double reach) const { return fixed + growing * std::pow(reach, power); }

Law fit_law(const std::vector<std::pair<double, double>>& points, int power) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [reach, value] : points) {
    const double x = std::pow(reach, power);
    n += 1;
    sx += x;
    sy += value;
    sxx += x * x;
    sxy += x * value;
  }
  Law law{sy / n, 0.0, power};
  const double determinant = n * sxx - sx * sx;
  if (determinant <= 0.0) return law;  // one bake: no growth to be seen
  law.growing = std::max(0.0, (n * sxy - sx * sy) / determinant);
  law.fixed = (sy - law.growing * sx) / n;
  if (law.fixed < 0.0) law = {0.0, sxy / sxx, power};
  return law;
}

}  // namespace prt::scaling
