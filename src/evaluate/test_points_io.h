// Test points in artifacts.
#pragma once

#include "evaluate/reference.h"
#include "store/artifact.h"

namespace prt {

void put_test_points(Artifact& out, const TestPoints& points);
/// Throws UnsoundData where they do not fit together.
TestPoints get_test_points(const Artifact& in);

}  // namespace prt
