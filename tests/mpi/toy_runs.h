// Running the toy's bake to its end.
#pragma once

#include <string>

#include "support/program.h"

namespace prt::test {

/// 40 leaves, 20 pairs, 1 total.
inline constexpr std::size_t kTasks = 61;
/// Microseconds: tasks long enough that a bake is surely still busy when its first artifact is
/// seen.
inline const std::string kSlowTask = "200000";

inline int run(const ToyFolder& folder, const ToyRun& run) {
  return folder.start(run, PRT_MPIRUN)->wait();
}

inline std::string log_of(const ToyFolder& folder) { return read_text(folder.path / "log.txt"); }

inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

}  // namespace prt::test
