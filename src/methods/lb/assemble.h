// The method's part of the runtime package.
#pragma once

#include "methods/method.h"

namespace prt::lb {

/// Program: direct light at samples with depth visibility; project; transfer; add; splats.
Package assemble_package(
    const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
    const OptionValues& options);

}  // namespace prt::lb
