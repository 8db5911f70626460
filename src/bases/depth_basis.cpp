#include "bases/depth_basis.h"

namespace prt {

std::uint16_t pack_depth(float t, float bound, bool escaped) {
  if (escaped) return kEscapedDepth;
  return static_cast<std::uint16_t>(std::lround(encode_depth(t, bound) * 65534.0F));
}

}  // namespace prt
