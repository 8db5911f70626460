// Logging facade: every line goes to stderr, with the rank where there are several.
#pragma once

#include <fmt/core.h>

#include <string>

namespace prt::log {

enum class Level { kDebug, kInfo, kWarn, kError };

/// Sets up the logger: stderr, colours on a terminal. `verbosity` -1 warnings only, 0 normal, 1
/// debug. `rank` < 0: not shown.
void set_up(int verbosity, int rank = -1);

/// While it lives, lines of this thread name what it works on: "rays/0007: ...".
class Subject {
 public:
  explicit Subject(const std::string& name);
  ~Subject();
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;

 private:
  std::string before_;
};

/// Writes one line, unless the verbosity hides its level.
void write(Level level, const std::string& line);

// spdlog stays out of this header: its own formatting templates cost seconds in every file that
// logs.
template <typename... Args>
void debug(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kDebug, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kInfo, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kWarn, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void error(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kError, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace prt::log
