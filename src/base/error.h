// Errors that are written for the person who runs the program.
#pragma once

#include <stdexcept>
#include <string>

namespace prt {

/// Process exit codes, the same for all four programs.
enum class ExitCode { kDone = 0, kFailure = 1, kBadInput = 2, kInterrupted = 3, kUnsound = 4 };

/// Something the user gave us is wrong (command line, configuration, scene, package). The message
/// is one line that names the file and the line or key, says what is wrong and what to do. Exit
/// code 2.
class UserError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Stored data cannot be trusted: corrupt, truncated, foreign or of another version. Inside a bake
/// the artifact is made again; `prt_inspect --verify` ends with exit code 4.
class UnsoundData : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The work was asked to stop and can be resumed. Exit code 3.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace prt
