#include "apps/prt_eval_report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <span>

#include "base/atomic_file.h"

namespace prt {

using nlohmann::json;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

ProgressLine::ProgressLine(std::string what, std::size_t count)
    : what_(std::move(what)), count_(count), shown_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::at(std::size_t number) const {
  if (!shown_) return;
  std::fputs(fmt::format("\r{} {} of {}", what_, number + 1, count_).c_str(), stderr);
  std::fflush(stderr);
}

namespace {

/// The report beside the package; an empty object where there is none.
json bake_report(const std::filesystem::path& package) {
  std::ifstream in(package.parent_path() / "report.json");
  json report = json::parse(in, nullptr, false);
  return report.is_object() ? report : json::object();
}

/// Its "bake_seconds"; null where it has none.
json bake_seconds(const json& report) {
  const auto found = report.find("bake_seconds");
  return found != report.end() && found->is_number() ? *found : json(nullptr);
}

/// CPU seconds by stage, the longest first: {stage, cpu_seconds}; empty where they are not known.
json bake_stages(const json& report) {
  const auto found = report.find("stages");
  if (found == report.end() || !found->is_array()) return json::array();
  std::vector<std::pair<double, std::string>> stages;
  for (const json& s : *found) {
    if (!s.is_object() || !s.contains("stage") || !s.contains("cpu_seconds")) continue;
    if (!s["stage"].is_string() || !s["cpu_seconds"].is_number()) continue;
    stages.emplace_back(s["cpu_seconds"].get<double>(), s["stage"].get<std::string>());
  }
  std::ranges::stable_sort(stages, std::greater<>(), [](const auto& s) { return s.first; });
  json all = json::array();
  for (const auto& [seconds, stage] : stages) {
    all.push_back({{"stage", stage}, {"cpu_seconds", seconds}});
  }
  return all;
}

void print_stages(const json& stages) {
  constexpr std::size_t kShown = 6;
  if (stages.empty()) return;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, stages.size()); ++i) {
    text += fmt::format("{}{} {:.1f}", i == 0 ? "" : ", ", stages[i]["stage"].get<std::string>(),
                        stages[i]["cpu_seconds"].get<double>());
  }
  fmt::print("  CPU seconds of the bake: {}{}\n", text, stages.size() > kShown ? ", ..." : "");
}

}  // namespace

void add_bake_figures(const EvalCommand& command, json& report) {
  report["package_bytes"] = std::filesystem::file_size(command.input);
  const json baked = bake_report(command.input);
  report["bake_seconds"] = bake_seconds(baked);
  report["bake_stages"] = bake_stages(baked);
}

void print_bake_figures(const json& report) {
  const json& bake = report["bake_seconds"];
  fmt::print("  package {:.2f} MB, player {:.1f} ms per light, bake {}\n",
             report["package_bytes"].get<double>() / 1e6, report["play_ms"].get<double>(),
             bake.is_number() ? fmt::format("{:.1f} s", bake.get<double>()) : "time not known");
  print_stages(report["bake_stages"]);
}

std::string percent(const json& value) {
  return value.is_number() ? fmt::format("{:.2f} %", 100.0 * value.get<double>()) : "-";
}

void print_row(const char* name, const json& figures) {
  fmt::print("  {:<22}{:>10}{:>10}{:>10}{:>12}{:>12}{:>10}\n", name, percent(figures["rel_rmse"]),
             percent(figures["rel_rmse_light"]["median"]),
             percent(figures["rel_rmse_light"]["p95"]), percent(figures["standard_error"]),
             percent(figures["light_error"]), percent(figures["negative_share"]));
}

void print_head() {
  fmt::print("  {:<22}{:>10}{:>10}{:>10}{:>12}{:>12}{:>10}\n", "relative RMS error", "pooled",
             "median", "95th", "noise", "lights", "negative");
}

void write_eval_report(const EvalCommand& command, const json& report,
                       const std::function<void(const json&)>& print) {
  if (command.json.empty()) {
    print(report);
    return;
  }
  const std::string text = report.dump(2) + "\n";
  if (command.json == "-") {
    std::fputs(text.c_str(), stdout);
  } else {
    write_file_atomically(command.json, std::as_bytes(std::span(text)));
  }
}

}  // namespace prt
