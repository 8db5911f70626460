#include "methods/lb/lb.h"
#include "methods/method.h"
#include "methods/sh/sh.h"

namespace prt {

const std::vector<const Method*>& all_methods() {
  static const std::vector<const Method*> methods = {&lb_method(), &sh_method()};
  return methods;
}

}  // namespace prt
