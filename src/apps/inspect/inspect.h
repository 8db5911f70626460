// prt_inspect as a library, so that tests can run it without a process.
#pragma once

#include <string>

#include "apps/inspect/command.h"
#include "base/error.h"

namespace prt {

/// Does what the command asks for; what is to be printed is appended to `out`. Throws UserError if
/// the folder holds no bake or not what a picture needs.
ExitCode inspect(const InspectCommand& command, std::string& out);

}  // namespace prt
