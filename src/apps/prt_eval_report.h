// What prt_eval's error reports have in common.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/prt_eval_command.h"

namespace prt {

double seconds_since(std::chrono::steady_clock::time_point start);

/// One line on a terminal that says how far the test lights are; nothing elsewhere.
class ProgressLine {
 public:
  ProgressLine(std::string what, std::size_t count);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  void at(std::size_t number) const;

 private:
  std::string what_;
  std::size_t count_;
  bool shown_;
};

/// package_bytes, and from the report beside the package bake_seconds and bake_stages.
void add_bake_figures(const EvalCommand& command, nlohmann::json& report);
/// Those and play_ms.
void print_bake_figures(const nlohmann::json& report);

std::string percent(const nlohmann::json& value);
void print_head();
/// A row below that head, of figures as to_json(IrradianceError) makes them.
void print_row(const char* name, const nlohmann::json& figures);

/// As a table, or as JSON where the command asks for it.
void write_eval_report(const EvalCommand& command, const nlohmann::json& report,
                       const std::function<void(const nlohmann::json&)>& print);

}  // namespace prt
