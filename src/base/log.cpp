#include "base/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <utility>

namespace prt::log {

namespace {
thread_local std::string subject;
}  // namespace

Subject::Subject(const std::string& name) : before_(std::exchange(subject, name)) {}
Subject::~Subject() { subject = std::move(before_); }

void set_up(int verbosity, int rank) {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  auto logger = std::make_shared<spdlog::logger>("prt", sink);
  const std::string who = rank >= 0 ? fmt::format("[{}] ", rank) : "";
  logger->set_pattern("%H:%M:%S.%e " + who + "%^%l%$ %v");
  logger->set_level(verbosity < 0   ? spdlog::level::warn
                    : verbosity > 0 ? spdlog::level::debug
                                    : spdlog::level::info);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

void write(Level level, const std::string& line) {
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                   spdlog::level::warn, spdlog::level::err};
  const std::string full = subject.empty() ? line : subject + ": " + line;
  spdlog::log(kLevels[static_cast<int>(level)], spdlog::string_view_t(full));
}

}  // namespace prt::log
