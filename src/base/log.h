// Logging facade over spdlog: every line goes to stderr, with the rank where there are several.
#pragma once

#include <spdlog/spdlog.h>

namespace prt::log {

using spdlog::debug;
using spdlog::error;
using spdlog::info;
using spdlog::warn;

/// Sets up the default logger: stderr, colours on a terminal. `verbosity` -1 warnings only, 0
/// normal, 1 debug. `rank` < 0: not shown.
void set_up(int verbosity, int rank = -1);

}  // namespace prt::log
