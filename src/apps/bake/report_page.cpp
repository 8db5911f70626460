#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bake/html.h"
#include "apps/bake/report.h"

namespace prt {

namespace {

using html::bar;
using html::escaped;
using html::number;
using html::percent;
using html::text_of;
using nlohmann::json;

std::string bytes_text(const json& bytes) {
  constexpr double kMega = 1e6;
  return fmt::format("{:.2f} MB", bytes.get<double>() / kMega);
}

/// A member of nested objects, null where there is none.
json member(const json& object, std::initializer_list<const char*> path) {
  const json* at = &object;
  for (const char* name : path) {
    if (!at->is_object() || !at->contains(name)) return nullptr;
    at = &(*at)[name];
  }
  return *at;
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

std::string facts(const json& object) {
  return "<div class=wide><table class=facts>\n" + rows_of(object) + "</table></div>\n";
}

std::string folded(const std::string& title, const std::string& content) {
  return "<details><summary>" + title + "</summary>\n" + content + "</details>\n";
}

std::string card(const std::string& name, const std::string& value, const std::string& note) {
  return "<div class=card><b>" + value + "</b><span>" + name + "</span><small>" + note +
         "</small></div>\n";
}

std::string cards(const json& report) {
  const json& error = report["error"];
  const auto plus_minus = [&](const char* kind) {
    return "± " + percent(member(error, {kind, "standard_error"})) + " noise, ± " +
           percent(member(error, {kind, "light_error"})) + " lights";
  };
  std::string all = "<div class=cards>\n";
  const json sky = member(error, {"environment", "total"});
  if (sky.is_null() || member(error, {"indirect"}).is_object()) {
    all += card("indirect light is off by", percent(member(error, {"indirect", "rel_rmse"})),
                plus_minus("indirect")) +
           card("direct light is off by", percent(member(error, {"direct", "rel_rmse"})),
                plus_minus("direct")) +
           card("shadow tests wrong", percent(member(error, {"visibility_error"})), "");
  }
  if (sky.is_object()) {
    all += card("light of the sky is off by", percent(member(sky, {"rel_rmse"})),
                "± " + percent(member(sky, {"standard_error"})) + " noise, ± " +
                    percent(member(sky, {"light_error"})) + " skies");
  }
  return all + card("package", bytes_text(report["package_bytes"]), "") +
         card("bake", fmt::format("{:.1f} s", report["bake_seconds"].get<double>()),
              fmt::format("{} triangles", text_of(report["scene"]["triangles"]))) +
         "</div>\n";
}

std::string gallery(const std::vector<ReportPicture>& pictures) {
  std::string out = "<div class=gallery>\n";
  for (const ReportPicture& p : pictures) {
    out += "<figure><img src=\"" + html::jpeg_address(p.jpeg) + "\" alt=\"" + escaped(p.title) +
           "\"><figcaption><b>" + escaped(p.title) + "</b> " + escaped(p.caption);
    if (!p.low.empty()) {
      out += "<span class=scale><span>" + escaped(p.low) + "</span><i></i><span>" +
             escaped(p.high) + "</span></span>";
    }
    out += "</figcaption></figure>\n";
  }
  return out + "</div>\n";
}

std::string error_table(const json& error) {
  std::string out =
      "<div class=wide><table><tr><th>relative RMS error</th><th>pooled</th><th>noise ±</th>"
      "<th>lights ±</th><th>median light</th><th>95th percentile</th></tr>\n";
  const auto line = [&](const char* name, const json& e) {
    if (!e.is_object()) return;
    out += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", name,
        percent(member(e, {"rel_rmse"})), percent(member(e, {"standard_error"})),
        percent(member(e, {"light_error"})), percent(member(e, {"rel_rmse_light", "median"})),
        percent(member(e, {"rel_rmse_light", "p95"})));
  };
  line("indirect, at samples", member(error, {"indirect"}));
  line("... were direct light exact", member(error, {"indirect", "exact_direct"}));
  line("indirect, on the surface", member(error, {"indirect", "surface"}));
  line("direct, at samples", member(error, {"direct"}));
  line("direct, on the surface", member(error, {"direct", "surface"}));
  for (const char* part : {"total", "direct", "indirect"}) {
    const std::string name = std::string("under skies, ") + part;
    line((name + ", at samples").c_str(), member(error, {"environment", part}));
    line((name + ", on the surface").c_str(), member(error, {"environment", part, "surface"}));
  }
  return out + "</table></div>\n";
}

/// A figure that nobody predicted is a dash, not a zero.
template <typename Text>
std::string predicted(const json& value, const Text& text) {
  return value.is_null() ? std::string("–") : text(value);
}

std::string seconds_text(const json& s) { return fmt::format("{:.2f}", s.get<double>()); }

std::string level_row(const json& level) {
  std::string out = "<tr>";
  for (const char* column : {"level", "samples"}) out += "<td>" + text_of(level[column]) + "</td>";
  for (const char* column : {"indirect", "standard_error", "light_error", "visibility"}) {
    out += "<td>" + percent(level[column]) + "</td>";
  }
  for (const char* column : {"predicted_seconds", "seconds"}) {
    out += "<td>" + predicted(member(level, {column}), seconds_text) + "</td>";
  }
  return out + "</tr>\n";
}

std::string levels_table(const json& levels) {
  std::string out =
      "<div class=wide><table><tr><th>level</th><th>samples</th><th>indirect</th><th>noise ±</th>"
      "<th>lights ±</th><th>visibility</th><th>predicted s</th><th>wall s</th></tr>\n";
  for (const json& level : levels) out += level_row(level);
  return out + "</table></div>\n";
}

std::string time_limit_text(const json& limit) {
  std::string out = fmt::format("<p><b>Time limit:</b> {} s; ", seconds_text(limit["seconds"]));
  const bool met = limit["met"].get<bool>();
  if (met) {
    out += fmt::format("met with level {} after {} s.", text_of(limit["level"]),
                       seconds_text(limit["used_seconds"]));
  } else {
    out += fmt::format("<b>not met</b>: level {}{} was done after {} s.", text_of(limit["level"]),
                       limit["level"] == 0 ? ", the coarsest," : "",
                       seconds_text(limit["used_seconds"]));
  }
  if (limit["next_seconds"].is_number()) {
    out += fmt::format(" The next was expected to take {} s.", seconds_text(limit["next_seconds"]));
  }
  return out + "</p>\n";
}

/// What was asked for, an accuracy or a time, and the levels that were made for it; nothing where
/// counts were.
std::string goals(const json& report) {
  const json accuracy = member(report, {"accuracy"});
  const json limit = member(report, {"time_limit"});
  std::string out;
  if (accuracy.is_object()) {
    out += "<p><b>Accuracy asked for:</b>";
    for (const auto& [figure, goal] : accuracy["goal"].items()) {
      out += fmt::format(" {} {}", escaped(figure), percent(goal));
    }
    out += accuracy["met"].get<bool>() ? ": met.</p>\n" : ": <b>not met</b>.</p>\n";
  }
  if (limit.is_object()) out += time_limit_text(limit);
  const json& of = limit.is_object() ? limit : accuracy;
  return of.is_object() ? out + levels_table(of["levels"]) : out;
}

constexpr std::size_t kWorstLights = 12;

/// One bar per test light, the worst first; all but so many are folded away.
std::string light_strip(const json& of_light) {
  std::string out;
  for (const char* kind : {"indirect", "direct"}) {
    std::vector<std::pair<double, std::size_t>> lights;
    const json values = member(of_light, {kind});
    if (!values.is_array()) continue;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i].is_number() && std::isfinite(values[i].get<double>())) {
        lights.emplace_back(values[i].get<double>(), i);
      }
    }
    if (lights.empty()) continue;
    std::ranges::sort(lights, std::greater<>());
    std::string rows;
    std::string rest;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const auto& [value, light] = lights[i];
      const double most = std::max(lights[0].first, 1e-12);
      (i < kWorstLights ? rows : rest) +=
          fmt::format("<tr><th>{}</th><td class=fill>{}</td><td>{}</td></tr>\n", light,
                      bar(value / most, "error"), value > 0.0 ? percent(value) : "below noise");
    }
    out += fmt::format("<h3>{} light, by test light</h3>\n<table class=bars>\n{}</table>\n", kind,
                       rows);
    if (!rest.empty()) {
      out += folded(fmt::format("the other {} lights", lights.size() - kWorstLights),
                    "<table class=bars>\n" + rest + "</table>\n");
    }
  }
  return out;
}

std::string budget_table(const json& budget) {
  std::string out =
      "<p>Each row makes one setting finer: what the error becomes, and the share of the squared "
      "error that goes away (negative: noise).</p>\n<div class=wide><table><tr><th>what</th>"
      "<th class=left>setting</th><th>indirect</th><th></th><th>share</th><th>direct</th><th></th>"
      "<th>share</th><th>on the surface</th><th>shadow tests</th></tr>\n";
  const auto line = [&](const json& row, bool is_base) {
    const auto name = [&](const char* figure) {
      return percent(member(row, {(is_base ? figure : (std::string(figure) + "_finer").c_str())}));
    };
    const auto share = [&](const char* figure) {
      const json value = member(row, {(std::string(figure) + "_share").c_str()});
      const double number = value.is_number() ? value.get<double>() : 0.0;
      return fmt::format("<td class=narrow>{}</td><td>{}</td>",
                         is_base ? "" : bar(number, "budget"), is_base ? "" : percent(value));
    };
    out += fmt::format("<tr><td>{}</td><td class=left>{}</td><td>{}</td>{}<td>{}</td>{}",
                       is_base ? "as baked" : text_of(member(row, {"what"})),
                       is_base ? "" : text_of(member(row, {"setting"})), name("indirect"),
                       share("indirect"), name("direct"), share("direct"));
    out +=
        fmt::format("<td>{}</td><td>{}</td></tr>\n", name("indirect_surface"), name("visibility"));
  };
  if (const json base = member(budget, {"base"}); base.is_object()) line(base, true);
  for (const json& row : budget["rows"]) {
    if (row.is_object()) line(row, false);
  }
  return out + "</table></div>\n";
}

std::string measured_text(const json& measured) {
  std::string text;
  for (const auto& [name, value] : measured.items()) {
    text += fmt::format("{}{} {:.3g} (max {:.3g})", text.empty() ? "" : ", ", escaped(name),
                        number(value, "mean", 0.0), number(value, "max", 0.0));
  }
  return text;
}

/// Time by stage, what was planned above what happened.
std::string stage_bars(const json& stages) {
  double most = 1e-9;
  for (const json& s : stages) {
    most = std::max({most, number(s, "seconds", 0.0), number(s, "predicted_seconds", 0.0)});
  }
  std::string out =
      "<p class=key><i class=planned></i> predicted <i class=taken></i> measured seconds of all "
      "tasks</p>\n<table class=bars>\n";
  for (const json& s : stages) {
    const double planned = number(s, "predicted_seconds", 0.0);
    const double taken = number(s, "seconds", 0.0);
    out +=
        fmt::format("<tr><th>{}</th><td class=fill>{}{}</td><td>{}<br>{:.2f}</td></tr>\n",
                    text_of(s["stage"]), bar(planned / most, "planned"), bar(taken / most, "taken"),
                    predicted(s["predicted_seconds"], seconds_text), taken);
  }
  return out + "</table>\n";
}

std::string stage_table(const json& stages) {
  std::string out =
      "<div class=wide><table><tr><th>stage</th><th>tasks</th><th>made</th><th>found</th>"
      "<th>predicted s</th><th>s</th><th>CPU s</th><th>predicted size</th><th>size</th>"
      "<th class=left>measured: mean (max)</th></tr>\n";
  for (const json& s : stages) {
    out += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.2f}</td>"
        "<td>{}</td><td>{}</td><td class=left>{}</td></tr>\n",
        text_of(s["stage"]), text_of(s["tasks"]), text_of(s["made"]), text_of(s["found"]),
        predicted(s["predicted_seconds"], seconds_text), s["seconds"].get<double>(),
        s["cpu_seconds"].get<double>(), predicted(s["predicted_bytes"], bytes_text),
        bytes_text(s["bytes"]), measured_text(s["measured"]));
  }
  return out + "</table></div>\n";
}

std::string left_out_table(const json& left_out) {
  if (left_out.empty()) return "<p>Nothing: this scene needed every part.</p>\n";
  std::string out = "<div class=wide><table><tr><th>what</th><th class=left>why</th></tr>\n";
  for (const json& l : left_out) {
    out += "<tr><td>" + text_of(l["what"]) + "</td><td class=left>" + text_of(l["reason"]) +
           "</td></tr>\n";
  }
  return out + "</table></div>\n";
}

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--paper:#fff;--ink:#1c2024;--soft:#667079;--line:#dfe3e8;--card:#f5f7f9;--a:#b9c4d0;--b:#2f6fb0;--c:#c0453a}
@media(prefers-color-scheme:dark){:root{--paper:#14171a;--ink:#e4e7ea;--soft:#98a2ac;--line:#2c3238;--card:#1e2226;--a:#4b5763;--b:#5b9fe0;--c:#e0776b}}
*{box-sizing:border-box}body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:76em;margin:0 auto;padding:1em}
h1{font-size:1.6em;margin:.4em 0 0;overflow-wrap:anywhere}h2{font-size:1.2em;margin:2em 0 .5em;border-bottom:1px solid var(--line)}h3{font-size:1em;margin:1.2em 0 .3em}
.sub,small,figcaption{color:var(--soft);overflow-wrap:anywhere}.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(11em,1fr));gap:.7em;margin:1em 0}
.card{background:var(--card);border-radius:8px;padding:.7em .9em}.card b{display:block;font-size:1.5em}.card span,.card small{display:block}
.gallery{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(28em,100%),1fr));gap:1em}figure{margin:0}img{width:100%;height:auto;border-radius:8px;display:block}figcaption b{color:var(--ink)}
.scale{display:flex;gap:.5em;align-items:center}.scale i{flex:1;height:.7em;border-radius:3px;background:linear-gradient(90deg,#440154,#414487,#2a788e,#22a884,#7ad151,#fde725)}
.wide{overflow-x:auto}table{border-collapse:collapse}td,th{padding:.25em .7em;border-bottom:1px solid var(--line);text-align:right;font-variant-numeric:tabular-nums;vertical-align:top}
th{font-weight:600}th:first-child,td:first-child,.left,.facts td{text-align:left}.facts td{overflow-wrap:anywhere}
.bars{width:100%}.bars th{font-weight:400;width:1%;white-space:nowrap}.bars td{width:1%;white-space:nowrap;line-height:1.15}.bars .fill{width:auto;vertical-align:middle}.bars td,.bars th{padding:.15em .4em;border:0}
.bar{display:block;width:100%;height:.7em;margin:1px 0}.narrow{min-width:5em}.planned rect{fill:var(--a)}.taken rect,.budget rect{fill:var(--b)}.error rect{fill:var(--c)}
.key i{display:inline-block;width:.9em;height:.7em;margin:0 .2em 0 .6em}.key .planned{background:var(--a)}.key .taken{background:var(--b)}
details{margin:.8em 0}summary{cursor:pointer;color:var(--soft)}
)";

std::string error_section(const json& report) {
  const json& error = report["error"];
  if (!error.is_object()) return goals(report) + "<p>Not measured.</p>\n";
  return "<p>Irradiance against a path-traced reference, under lights that training never "
         "saw.</p>\n" +
         goals(report) + error_table(error) + light_strip(member(report, {"error_of_light"})) +
         folded("every figure", facts(error));
}

/// What was mended, left out or moved while loading.
std::string scene_notes(const json& report) {
  std::string out;
  for (const json& note : member(report, {"scene", "repair_notes"})) {
    out += "<p class=sub>scene: " + text_of(note) + "</p>\n";
  }
  return out;
}

}  // namespace

std::string report_page(const json& report, const std::vector<ReportPicture>& pictures,
                        const json& budget) {
  const std::string title = text_of(report["package"]);
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
      "<link rel=\"icon\" href=\"data:,\"><title>" +
      title + "</title><style>" + kStyle + "</style></head><body>\n<h1>" + title +
      "</h1>\n<p class=sub>" + text_of(report["scene"]["file"]) + " · method " +
      text_of(report["method"]) + " · " + text_of(report["scene"]["repairs"]) + " repairs</p>\n" +
      scene_notes(report) + cards(report);
  if (!pictures.empty()) page += "<h2>What was baked</h2>\n" + gallery(pictures);
  page += "<h2>How wrong it is</h2>\n" + error_section(report);
  if (budget.is_object()) page += "<h2>Where the error comes from</h2>\n" + budget_table(budget);
  page += "<h2>Where the time went</h2>\n" + stage_bars(report["stages"]) +
          folded("tasks, bytes and what each stage measured", stage_table(report["stages"]));
  if (report["survey"].is_object()) page += "<h2>The scene</h2>\n" + facts(report["survey"]);
  page += "<h2>What was left out</h2>\n" + left_out_table(report["left_out"]);
  page += "<h2>This run</h2>\n" + folded("ranks, hosts, threads", facts(report["this_run"])) +
          folded("options", facts(report["options"])) + "</body></html>\n";
  return page;
}

}  // namespace prt
