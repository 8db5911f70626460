#include "apps/inspect/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/log.h"

namespace prt {

namespace {

using nlohmann::json;

StageRow& row_of_stage(BakeTables& tables, const std::string& stage) {
  const auto it = std::ranges::find(tables.stages, stage, &StageRow::stage);
  if (it != tables.stages.end()) return *it;
  tables.stages.push_back({.stage = stage});
  return tables.stages.back();
}

json number_or_null(const json& attributes, const char* name) {
  const auto it = attributes.find(name);
  return it != attributes.end() && it->is_number() ? *it : json();
}

/// Adds an artifact that says which cluster it belongs to.
void add_to_cluster(std::map<std::int64_t, ClusterRow>& rows, const ManifestEntry& entry,
                    std::uint64_t bytes, const json& attributes) {
  const json cluster = number_or_null(attributes, "cluster");
  if (cluster.is_null()) return;
  ClusterRow& row = rows[cluster.get<std::int64_t>()];
  row.cluster = cluster.get<std::int64_t>();
  row.bytes += bytes;
  row.seconds += entry.seconds;
  if (const json samples = number_or_null(attributes, "samples"); !samples.is_null()) {
    row.samples = samples.get<std::int64_t>();
  }
  const ClusterFigures figures{number_or_null(attributes, "rank"),
                               number_or_null(attributes, "energy"),
                               number_or_null(attributes, "error")};
  if (!figures.rank.is_null() || !figures.error.is_null()) row.figures[entry.kind] = figures;
}

json read_report(const BakeReader& bake) {
  const auto path = bake.path() / "report.json";
  if (!bake.file_system().size(path)) return nullptr;
  const auto bytes = bake.file_system().read(path);
  const auto* begin = reinterpret_cast<const char*>(bytes.data());
  json report = json::parse(begin, begin + bytes.size(), nullptr, false);
  if (report.is_object()) return report;
  log::warn("{}: cannot be read; run prt_bake again to have it made anew", path.string());
  return nullptr;
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 10'000) return fmt::format("{} B", bytes);
  if (bytes < 10'000'000) return fmt::format("{:.1f} kB", static_cast<double>(bytes) * 1e-3);
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6);
}

std::string figure_text(const json& figure, const char* format) {
  if (figure.is_null()) return "-";
  const double number = figure.get<double>();
  return fmt::vformat(format, fmt::make_format_args(number));
}

void append_stages(std::string& out, const BakeTables& tables) {
  auto to = std::back_inserter(out);
  StageRow sum{.stage = "all"};
  fmt::format_to(to, "{:<20}{:>7}{:>12}{:>11}{:>11}\n", "stage", "tasks", "bytes", "seconds",
                 "CPU s");
  const auto line = [&](const StageRow& row) {
    fmt::format_to(to, "{:<20}{:>7}{:>12}{:>11.2f}{:>11.2f}{}\n", row.stage, row.tasks,
                   bytes_text(row.bytes), row.seconds, row.cpu_seconds,
                   row.missing > 0 ? fmt::format("  ({} not kept)", row.missing) : "");
  };
  for (const StageRow& row : tables.stages) {
    line(row);
    sum.tasks += row.tasks;
    sum.missing += row.missing;
    sum.bytes += row.bytes;
    sum.seconds += row.seconds;
    sum.cpu_seconds += row.cpu_seconds;
  }
  line(sum);
}

void append_clusters(std::string& out, const BakeTables& tables) {
  if (tables.clusters.empty()) return;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "\n{:<8}{:>8}{:>12}{:>9}", "", "", "", "");
  for (const std::string& stage : tables.figure_stages) fmt::format_to(to, " | {:<23}", stage);
  fmt::format_to(to, "\n{:<8}{:>8}{:>12}{:>9}", "cluster", "samples", "bytes", "seconds");
  for (std::size_t i = 0; i < tables.figure_stages.size(); ++i) {
    fmt::format_to(to, " | {:>5}{:>9}{:>9}", "rank", "energy", "error");
  }
  out += '\n';
  for (const ClusterRow& row : tables.clusters) {
    fmt::format_to(to, "{:<8}{:>8}{:>12}{:>9.2f}", row.cluster, row.samples, bytes_text(row.bytes),
                   row.seconds);
    for (const std::string& stage : tables.figure_stages) {
      const auto it = row.figures.find(stage);
      const ClusterFigures figures = it == row.figures.end() ? ClusterFigures{} : it->second;
      fmt::format_to(to, " | {:>5}{:>9}{:>9}", figure_text(figures.rank, "{:.0f}"),
                     figure_text(figures.energy, "{:.5f}"), figure_text(figures.error, "{:.5f}"));
    }
    out += '\n';
  }
}

/// "left out" entries of the report, null if there are none.
json left_out(const BakeTables& tables) {
  const auto it = tables.report.find("left_out");
  return it != tables.report.end() && it->is_array() ? *it : json::array();
}

void append_report(std::string& out, const BakeTables& tables) {
  auto to = std::back_inserter(out);
  if (tables.report.is_null()) {
    out += "\nNot complete: prt_bake with the same configuration goes on.\n";
    return;
  }
  for (const json& entry : left_out(tables)) {
    if (!entry.is_object()) continue;
    fmt::format_to(to, "\nleft out: {} ({})", entry.value("what", "?"), entry.value("reason", "?"));
  }
  if (!left_out(tables).empty()) out += '\n';
}

}  // namespace

BakeTables make_tables(const BakeReader& bake) {
  BakeTables tables;
  tables.identity = bake.manifest().identity;
  std::map<std::int64_t, ClusterRow> clusters;
  for (const ManifestEntry& entry : bake.entries()) {
    StageRow& stage = row_of_stage(tables, entry.kind);
    const std::uint64_t bytes = bake.store().bytes(entry.kind, entry.key);
    ++stage.tasks;
    stage.missing += bytes == 0 ? 1 : 0;
    stage.bytes += bytes;
    stage.seconds += entry.seconds;
    stage.cpu_seconds += entry.cpu_seconds;
    if (bytes == 0) continue;
    try {
      const auto head = bake.store().head(entry.kind, entry.key);
      add_to_cluster(clusters, entry, bytes, head.artifact.attributes);
    } catch (const UnsoundData& error) {
      log::warn("{}", error.what());
      ++tables.unreadable;
    }
  }
  for (auto& [cluster, row] : clusters) tables.clusters.push_back(std::move(row));
  for (const StageRow& stage : tables.stages) {
    const bool has_figures = std::ranges::any_of(
        tables.clusters, [&](const ClusterRow& row) { return row.figures.contains(stage.stage); });
    if (has_figures) tables.figure_stages.push_back(stage.stage);
  }
  tables.report = read_report(bake);
  return tables;
}

std::string to_text(const BakeTables& tables) {
  std::string out = tables.identity.empty() ? "" : tables.identity + "\n\n";
  append_stages(out, tables);
  append_clusters(out, tables);
  append_report(out, tables);
  if (tables.unreadable > 0) {
    out += fmt::format(
        "\n{} artifact(s) cannot be trusted; --verify tells more, prt_bake makes "
        "them again.\n",
        tables.unreadable);
  }
  return out;
}

json to_json(const BakeTables& tables) {
  json stages = json::array();
  for (const StageRow& row : tables.stages) {
    stages.push_back({{"stage", row.stage},
                      {"tasks", row.tasks},
                      {"not_kept", row.missing},
                      {"bytes", row.bytes},
                      {"seconds", row.seconds},
                      {"cpu_seconds", row.cpu_seconds}});
  }
  json clusters = json::array();
  for (const ClusterRow& row : tables.clusters) {
    json figures = json::object();
    for (const auto& [stage, f] : row.figures) {
      figures[stage] = {{"rank", f.rank}, {"energy", f.energy}, {"error", f.error}};
    }
    clusters.push_back({{"cluster", row.cluster},
                        {"samples", row.samples},
                        {"bytes", row.bytes},
                        {"seconds", row.seconds},
                        {"stages", figures}});
  }
  return {{"bake", tables.identity},
          {"complete", !tables.report.is_null()},
          {"stages", stages},
          {"clusters", clusters},
          {"left_out", left_out(tables)},
          {"unreadable", tables.unreadable}};
}

}  // namespace prt
