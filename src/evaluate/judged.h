// Values beside their references. Internal to evaluate/.
#pragma once

#include <functional>
#include <vector>

#include "evaluate/metrics.h"
#include "evaluate/reference.h"

namespace prt {

/// Values, two references of each, and the area share that each stands for.
struct Judged {
  std::vector<Vec3f> values, first, second;
  std::vector<float> weights;
  void add(const Vec3f& value, const Vec3f& r1, const Vec3f& r2, float weight) {
    values.push_back(value);
    first.push_back(r1);
    second.push_back(r2);
    weights.push_back(weight);
  }
  [[nodiscard]] IrradianceSums sums() const {
    return irradiance_sums(values, first, second, weights);
  }
};

/// What a set of test points says of `part` (direct or indirect).
inline Judged judge(const TestSet& set, std::array<Vec3f, 2> IrradianceEstimate::*part,
                    const std::function<Vec3f(std::size_t)>& value) {
  Judged judged;
  for (std::size_t i = 0; i < set.points.size(); ++i) {
    const auto& reference = set.reference[i].*part;
    judged.add(value(i), reference[0], reference[1], set.weights[i]);
  }
  return judged;
}

}  // namespace prt
