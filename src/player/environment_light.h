// An environment as packages take it.
#pragma once

#include "bases/spherical_harmonics.h"
#include "package/package.h"
#include "scene/environment.h"

namespace prt {

/// The spherical harmonics of an environment, projected once: turning it costs microseconds.
class EnvironmentLight {
 public:
  /// `order`: environment_order() of the package. Projected with solid-angle weights, in pieces of
  /// at most 0.7 degrees.
  EnvironmentLight(const Environment& environment, int order);
  [[nodiscard]] int order() const { return order_; }
  /// Coefficients of its radiance, W/(m² sr), 3 × order², as Evaluator::evaluate takes them, of the
  /// environment turned by so many degrees about +Y, counter-clockwise as seen from above.
  [[nodiscard]] MatrixF coefficients(double degrees = 0.0) const;

 private:
  int order_;
  MatrixD coefficients_;  // order² × 3
};

/// Throws std::invalid_argument unless `environment` is none (empty) or of the package's order,
/// where it takes one.
void check_environment(const Package& package, const MatrixF& environment);

}  // namespace prt
