#include "operators/blocks.h"

namespace prt {

std::vector<std::uint32_t> ClusterProjection::coefficient_begin() const {
  std::vector<std::uint32_t> begin{0};
  for (const QuantisedMatrix& block : blocks) begin.push_back(begin.back() + block.rows);
  return begin;
}

}  // namespace prt
