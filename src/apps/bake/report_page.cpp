#include <fmt/format.h>

#include "apps/bake/report.h"

namespace prt {

namespace {

using nlohmann::json;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string text_of(const json& value) {
  if (value.is_string()) return escaped(value.get<std::string>());
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  return escaped(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

std::string bytes_text(const json& bytes) {
  constexpr double kMega = 1e6;
  return fmt::format("{:.2f} MB", bytes.get<double>() / kMega);
}

std::string row(const std::string& name, const std::string& value) {
  return "<tr><th>" + escaped(name) + "</th><td>" + value + "</td></tr>\n";
}

/// Nested objects as dotted names: "indirect.rel_rmse".
std::string rows_of(const json& object, const std::string& prefix = "") {
  std::string rows;
  for (const auto& [name, value] : object.items()) {
    rows += value.is_object() ? rows_of(value, prefix + name + ".")
                              : row(prefix + name, text_of(value));
  }
  return rows;
}

std::string measured_text(const json& measured) {
  std::string text;
  for (const auto& [name, value] : measured.items()) {
    text += fmt::format("{}{} {:.3g} (max {:.3g})", text.empty() ? "" : ", ", escaped(name),
                        value["mean"].get<double>(), value["max"].get<double>());
  }
  return text;
}

std::string stage_table(const json& stages) {
  const auto predicted = [](const json& value, const auto& text) {
    return value.is_null() ? std::string("–") : text(value);
  };
  const auto seconds = [](const json& s) { return fmt::format("{:.2f}", s.get<double>()); };
  std::string html =
      "<table><tr><th>stage</th><th>tasks</th><th>made</th><th>found</th><th>predicted s</th>"
      "<th>s</th><th>CPU s</th><th>predicted size</th><th>size</th><th>measured: mean (max)</th>"
      "</tr>\n";
  for (const json& s : stages) {
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.2f}</td>"
        "<td>{}</td><td>{}</td><td class=left>{}</td></tr>\n",
        text_of(s["stage"]), text_of(s["tasks"]), text_of(s["made"]), text_of(s["found"]),
        predicted(s["predicted_seconds"], seconds), s["seconds"].get<double>(),
        s["cpu_seconds"].get<double>(), predicted(s["predicted_bytes"], bytes_text),
        bytes_text(s["bytes"]), measured_text(s["measured"]));
  }
  return html + "</table>\n";
}

std::string left_out_table(const json& left_out) {
  if (left_out.empty()) return "<p>Nothing.</p>\n";
  std::string html = "<table><tr><th>what</th><th>why</th></tr>\n";
  for (const json& l : left_out) {
    html += "<tr><td class=left>" + text_of(l["what"]) + "</td><td class=left>" +
            text_of(l["reason"]) + "</td></tr>\n";
  }
  return html + "</table>\n";
}

constexpr const char* kStyle =
    "body{font:15px sans-serif;margin:2em;max-width:80em}table{border-collapse:collapse}"
    "td,th{padding:.2em .8em;border-bottom:1px solid #ccc;text-align:right}"
    "th:first-child,td:first-child,.left{text-align:left}.facts td{text-align:left}";

}  // namespace

std::string report_page(const json& report) {
  const std::string title = text_of(report["package"]);
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                     title + "</title><style>" + kStyle + "</style></head><body>\n<h1>" + title +
                     "</h1>\n<table class=facts>\n";
  html += row("scene", text_of(report["scene"]["file"]));
  html += row("triangles", text_of(report["scene"]["triangles"]));
  html += row("repairs", text_of(report["scene"]["repairs"]));
  html += row("method", text_of(report["method"]));
  html += row("package", bytes_text(report["package_bytes"]));
  html += row("bake", fmt::format("{:.1f} s", report["bake_seconds"].get<double>()));
  html += "</table>\n<h2>Error against the path-traced reference</h2>\n";
  html += report["error"].is_object()
              ? "<table class=facts>\n" + rows_of(report["error"]) + "</table>\n"
              : "<p>Not measured.</p>\n";
  html += "<h2>Stages</h2>\n" + stage_table(report["stages"]);
  if (report["survey"].is_object()) {
    html += "<h2>The scene</h2>\n<table class=facts>\n" + rows_of(report["survey"]) + "</table>\n";
  }
  html += "<h2>Left out</h2>\n" + left_out_table(report["left_out"]);
  html += "<h2>This run</h2>\n<table class=facts>\n" + rows_of(report["this_run"]) + "</table>\n";
  html += "<h2>Options</h2>\n<table class=facts>\n" + rows_of(report["options"]) +
          "</table>\n</body></html>\n";
  return html;
}

}  // namespace prt
