// The method's part of the runtime package.
#pragma once

#include "methods/method.h"

namespace prt::sh {

/// Without a program where the plan left the environment out.
Package assemble_package(
    const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
    const OptionValues& options);

}  // namespace prt::sh
