#include "bases/spherical_harmonics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"

namespace prt {
namespace {

constexpr double kPiD = 3.14159265358979323846;
// Sums of some hundred products of order one, in double.
constexpr double kDouble = 1e-12;

Vec3d random_direction(std::uint64_t i) {
  Random random(17, i);
  const float u = random.uniform(), v = random.uniform();
  return sphere_direction(u, v).cast<double>().normalized();
}

Eigen::Matrix3d random_rotation(std::uint64_t i) {
  Random random(23, i);
  Eigen::Quaterniond q(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5,
                       random.uniform() - 0.5);
  return q.normalized().toRotationMatrix();
}

MatrixD gram(int order, const SphereQuadrature& quadrature) {
  MatrixD sum = MatrixD::Zero(sh_count(order), sh_count(order));
  for (std::size_t i = 0; i < quadrature.directions.size(); ++i) {
    const VectorD y = evaluate_sh(order, quadrature.directions[i]);
    sum += quadrature.weights[i] * y * y.transpose();
  }
  return sum;
}

double largest(const MatrixD& m) { return m.cwiseAbs().maxCoeff(); }

TEST(SphericalHarmonics, HaveTheTutorialsClosedForms) {
  const Vec3d d = random_direction(1);
  const VectorD y = evaluate_sh(3, d);
  const double one = std::sqrt(3.0 / (4.0 * kPiD));
  const double two = std::sqrt(15.0 / (4.0 * kPiD));
  EXPECT_NEAR(y[0], std::sqrt(1.0 / (4.0 * kPiD)), kDouble);
  EXPECT_NEAR(y[sh_index(1, -1)], -one * d.y(), kDouble);
  EXPECT_NEAR(y[sh_index(1, 0)], one * d.z(), kDouble);
  EXPECT_NEAR(y[sh_index(1, 1)], -one * d.x(), kDouble);
  EXPECT_NEAR(y[sh_index(2, -2)], two * d.x() * d.y(), kDouble);
  EXPECT_NEAR(y[sh_index(2, -1)], -two * d.y() * d.z(), kDouble);
  EXPECT_NEAR(y[sh_index(2, 0)], std::sqrt(5.0 / (16.0 * kPiD)) * (3.0 * d.z() * d.z() - 1.0),
              kDouble);
  EXPECT_NEAR(y[sh_index(2, 2)], 0.5 * two * (d.x() * d.x() - d.y() * d.y()), kDouble);
}

TEST(SphericalHarmonics, AreOrthonormalUnderAnExactQuadrature) {
  for (int order = 1; order <= kMostShOrder; ++order) {
    const MatrixD identity = MatrixD::Identity(sh_count(order), sh_count(order));
    EXPECT_LT(largest(gram(order, exact_quadrature(order)) - identity), kDouble) << order;
  }
  // One node fewer and it is exact no longer: the bound above can be missed.
  const MatrixD identity = MatrixD::Identity(sh_count(8), sh_count(8));
  EXPECT_GT(largest(gram(8, exact_quadrature(7)) - identity), 1e-3);
}

TEST(SphericalHarmonics, StayOrthonormalInBandsFarBeyondFactorials) {
  constexpr int kHigh = 24;  // 46! is far beyond float
  const MatrixD identity = MatrixD::Identity(sh_count(kHigh), sh_count(kHigh));
  EXPECT_LT(largest(gram(kHigh, exact_quadrature(kHigh)) - identity), kDouble);
}

TEST(SphericalHarmonics, KeepTheAdditionTheorem) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Vec3d a = random_direction(2 * i), b = random_direction(2 * i + 1);
    const VectorD ya = evaluate_sh(kMostShOrder, a), yb = evaluate_sh(kMostShOrder, b);
    for (int l = 0; l < kMostShOrder; ++l) {
      const double sum =
          ya.segment(sh_index(l, -l), 2 * l + 1).dot(yb.segment(sh_index(l, -l), 2 * l + 1));
      const double legendre = std::legendre(static_cast<unsigned>(l), a.dot(b));
      EXPECT_NEAR(sum, (2.0 * l + 1.0) / (4.0 * kPiD) * legendre, kDouble) << l;
    }
  }
}

TEST(ShRotation, TurnsFunctions) {
  for (std::uint64_t i = 0; i < 10; ++i) {
    const Eigen::Matrix3d r = random_rotation(i);
    const ShRotation rotation(kMostShOrder, r);
    const MatrixD y = evaluate_sh(kMostShOrder, random_direction(i));
    const MatrixD turned = evaluate_sh(kMostShOrder, r * random_direction(i));
    EXPECT_LT(largest(rotation.apply(y) - turned), kDouble);
  }
}

TEST(ShRotation, IsOrthogonalAndComposes) {
  const Eigen::Matrix3d a = random_rotation(1), b = random_rotation(2);
  const ShRotation ra(kMostShOrder, a), rb(kMostShOrder, b), both(kMostShOrder, a * b);
  const MatrixD c = MatrixD::Random(sh_count(kMostShOrder), 3);
  EXPECT_LT(largest(ra.apply(rb.apply(c)) - both.apply(c)), kDouble);
  for (int l = 0; l < kMostShOrder; ++l) {
    const MatrixD identity = MatrixD::Identity(2 * l + 1, 2 * l + 1);
    EXPECT_LT(largest(ra.band(l) * ra.band(l).transpose() - identity), kDouble) << l;
  }
  EXPECT_LT(largest(band_energy(kMostShOrder, ra.apply(c)) - band_energy(kMostShOrder, c)), 1e-11);
}

TEST(ShRotation, OfAPoleOrTheIdentityIsExact) {
  const ShRotation none(kMostShOrder, Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d half = Vec3d(1.0, -1.0, -1.0).asDiagonal();
  const ShRotation turned(kMostShOrder, half);
  for (int l = 0; l < kMostShOrder; ++l) {
    EXPECT_LT(largest(none.band(l) - MatrixD::Identity(2 * l + 1, 2 * l + 1)), kDouble);
    EXPECT_NEAR(turned.band(l)(l, l), l % 2 == 0 ? 1.0 : -1.0, kDouble);
  }
}

TEST(LambertLobe, HasTheIntegralsClosedForm) {
  // Each coefficient is 2π ∫_0^1 z P_l(z) dz: by Gauss–Legendre on the half interval.
  const std::vector<double> bands = lambert_bands(kMostShOrder);
  const SphereQuadrature nodes = exact_quadrature(16);
  for (int l = 0; l < kMostShOrder; ++l) {
    double integral = 0.0;
    for (std::size_t i = 0; i < nodes.directions.size(); i += 31) {  // one of each height
      const double z = 0.5 * (nodes.directions[i].z() + 1.0);
      const double weight = 0.5 * nodes.weights[i] * 31.0 / (2.0 * kPiD);
      integral += 2.0 * kPiD * weight * z * std::legendre(static_cast<unsigned>(l), z);
    }
    EXPECT_NEAR(bands[static_cast<std::size_t>(l)], integral, kDouble) << l;
  }
}

TEST(LambertLobe, OfAConstantSkyIsPi) {
  MatrixD sky = MatrixD::Zero(sh_count(5), 1);
  sky(0) = std::sqrt(4.0 * kPiD);  // radiance 1
  const VectorD transfer = lambert_sh(5, random_direction(3));
  EXPECT_NEAR(transfer.dot(sky.col(0)), kPiD, kDouble);
}

double lobe(const Vec3d& d) { return std::exp(3.0 * (d.x() - 1.0)); }

TEST(Projection, ByStratifiedAndEqualAreaDirectionsFindsTheCoefficients) {
  const auto f = [](const Vec3d& d) { return Vec3d(lobe(d), 2.0 * lobe(d), 0.0); };
  const MatrixD exact = project_sh(5, exact_quadrature(24), f);
  const MatrixD stratified = project_sh(5, stratified_quadrature(100, 5), f);
  const MatrixD equal_area = project_sh(5, equal_area_quadrature(100), f);
  // 10,000 directions: jittered cells err by about 1 / n of the norm, midpoints by less.
  EXPECT_LT((stratified - exact).norm(), 2e-3 * exact.norm());
  EXPECT_LT((equal_area - exact).norm(), 5e-4 * exact.norm());
  EXPECT_GT((stratified - exact).norm(), 0.0);
  EXPECT_NEAR((exact.col(1) - 2.0 * exact.col(0)).norm(), 0.0, kDouble);
}

TEST(Window, FallsFromOneAndTakesTheRinging) {
  const std::vector<double> bands = hann_bands(5, 5.0);
  EXPECT_DOUBLE_EQ(bands[0], 1.0);
  for (std::size_t l = 1; l < bands.size(); ++l) EXPECT_LT(bands[l], bands[l - 1]);
  EXPECT_EQ(hann_bands(4, 0.0), std::vector<double>(4, 1.0));
  EXPECT_EQ(hann_bands(4, 2.0)[3], 0.0);
  // A point of light in five bands is negative in places; under the window far less so.
  MatrixD plain = evaluate_sh(5, Vec3d::UnitZ());
  MatrixD windowed = plain;
  scale_bands(bands, windowed);
  double lowest = 0.0, lowest_windowed = 0.0;
  for (int i = 0; i <= 180; ++i) {
    const double angle = kPiD * i / 180.0;
    const VectorD y = evaluate_sh(5, {std::sin(angle), 0.0, std::cos(angle)});
    lowest = std::min(lowest, y.dot(plain.col(0)));
    lowest_windowed = std::min(lowest_windowed, y.dot(windowed.col(0)));
  }
  EXPECT_LT(lowest, -0.3);
  EXPECT_GT(lowest_windowed, 0.25 * lowest);
}

}  // namespace
}  // namespace prt
