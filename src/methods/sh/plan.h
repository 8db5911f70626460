// Which tasks there are.
#pragma once

#include "methods/method.h"

namespace prt::sh {

inline constexpr const char* kDirect = "sky_direct";
inline constexpr const char* kBounce = "sky_bounce";
inline constexpr const char* kTransfer = "sky_transfer";

/// Light bounces at most so many times where transport.bounces is auto: an open scene loses it
/// sooner.
inline constexpr int kMostBounces = 64;

/// What a scene's surfaces do to the light that makes transfer (sh.transfer).
enum class Transfer { kUnshadowed, kShadowed, kInterreflected };
Transfer transfer_of(const OptionValues& options);

Plan make_plan(const PlanInputs& inputs);

}  // namespace prt::sh
