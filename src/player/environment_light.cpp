#include "player/environment_light.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <stdexcept>

namespace prt {
namespace {

/// The midpoint rule is off by some 1e-5 of a coefficient then.
constexpr int kLeastRows = 256;

}  // namespace

EnvironmentLight::EnvironmentLight(const Environment& environment, int order)
    : order_(order), coefficients_(MatrixD::Zero(sh_count(order), 3)) {
  VectorD values(sh_count(order));
  environment.visit(kLeastRows, [&](const Vec3d& direction, double weight, const Vec3f& radiance) {
    if (radiance.isZero(0.0F)) return;
    evaluate_sh(order, direction, {values.data(), static_cast<std::size_t>(values.size())});
    coefficients_ += values * (weight * radiance.cast<double>()).transpose();
  });
}

MatrixF EnvironmentLight::coefficients(double degrees) const {
  const double angle = degrees * static_cast<double>(kPi) / 180.0;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vec3d::UnitY()).toRotationMatrix();
  return ShRotation(order_, turn).apply(coefficients_).transpose().cast<float>();
}

void check_environment(const Package& package, const MatrixF& environment) {
  const int order = environment_order(package);
  if (environment.size() == 0 || order == 0) return;
  if (environment.rows() == 3 && environment.cols() == sh_count(order)) return;
  throw std::invalid_argument(fmt::format("an environment of {} x {} coefficients is not 3 x {}",
                                          environment.rows(), environment.cols(), sh_count(order)));
}

}  // namespace prt
