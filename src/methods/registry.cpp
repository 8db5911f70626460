#include "methods/method.h"

namespace prt {

const std::vector<const Method*>& all_methods() {
  static const std::vector<const Method*> methods = {};
  return methods;
}

}  // namespace prt
