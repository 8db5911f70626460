// Several methods in one bake: what two of them plan alike is made once, and their parts of the
// package add up.
#pragma once

#include <memory>
#include <vector>

#include "methods/method.h"

namespace prt {

/// The method that is all of `methods`, which outlive it; of one, that one.
std::shared_ptr<const Method> combined(const std::vector<const Method*>& methods);

/// Adds what `part` plays to what `whole` plays: spaces, operators and the sum of both programs.
/// Both are of the same samples. A part without a program adds nothing. Throws std::logic_error
/// where both have a space or an operator of one name.
void add_part(Package& whole, Package part);

}  // namespace prt
