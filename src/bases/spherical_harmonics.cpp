#include "bases/spherical_harmonics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"

namespace prt {
namespace {

constexpr double kPiD = 3.14159265358979323846;

/// y_lm of fixed m from the normalised Legendre function over sin^m θ, which is a polynomial in z.
class Column {
 public:
  Column(int m, double diagonal, double z) : m_(m), z_(z), current_(diagonal) {}
  [[nodiscard]] double value() const { return current_; }
  /// From band l − 1 to l.
  void step(int l) {
    const double l2 = static_cast<double>(l) * l;
    const double m2 = static_cast<double>(m_) * m_;
    const double below = (l - 1.0) * (l - 1.0);
    const double a = std::sqrt((4.0 * l2 - 1.0) / (l2 - m2));
    const double b = l == m_ + 1 ? 0.0 : std::sqrt((below - m2) / (4.0 * below - 1.0));
    const double next = a * (z_ * current_ - b * before_);
    before_ = current_;
    current_ = next;
  }

 private:
  int m_;
  double z_;
  double current_;
  double before_ = 0.0;
};

}  // namespace

void evaluate_sh(int order, const Vec3d& direction, std::span<double> values) {
  double diagonal = std::sqrt(0.25 / kPiD);  // band m over (x + iy)^m
  double real = 1.0;                         // of (x + iy)^m
  double imaginary = 0.0;
  for (int m = 0; m < order; ++m) {
    if (m > 0) {
      diagonal *= -std::sqrt((2.0 * m + 1.0) / (2.0 * m));
      const double next = direction.x() * real - direction.y() * imaginary;
      imaginary = direction.x() * imaginary + direction.y() * real;
      real = next;
    }
    const double scale = m == 0 ? 1.0 : std::sqrt(2.0);
    Column column(m, diagonal, direction.z());
    for (int l = m; l < order; ++l) {
      if (l > m) column.step(l);
      values[static_cast<std::size_t>(sh_index(l, m))] = scale * column.value() * real;
      if (m > 0)
        values[static_cast<std::size_t>(sh_index(l, -m))] = scale * column.value() * imaginary;
    }
  }
}

VectorD evaluate_sh(int order, const Vec3d& direction) {
  VectorD values(sh_count(order));
  evaluate_sh(order, direction, {values.data(), static_cast<std::size_t>(values.size())});
  return values;
}

namespace {

/// The recurrence's terms for one band, from the band below; signs without the Condon–Shortley
/// phase, as in the paper.
class RotationBand {
 public:
  RotationBand(int l, const MatrixD& first, const MatrixD& below)
      : l_(l), first_(first), below_(below) {}

  [[nodiscard]] MatrixD make() const {
    MatrixD band(2 * l_ + 1, 2 * l_ + 1);
    for (int m = -l_; m <= l_; ++m) {
      for (int n = -l_; n <= l_; ++n) band(m + l_, n + l_) = entry(m, n);
    }
    return band;
  }

 private:
  [[nodiscard]] double entry(int m, int n) const {
    const double l = l_;
    const double of_m = std::abs(m);
    const double d = std::abs(n) < l_ ? (l + n) * (l - n) : 2.0 * l * (2.0 * l - 1.0);
    const double u = std::sqrt((l + m) * (l - m) / d);
    const double twice = m == 0 ? 2.0 : 1.0;
    const double sign = m == 0 ? -1.0 : 1.0;
    const double v = 0.5 * sign * std::sqrt(twice * (l + of_m - 1.0) * (l + of_m) / d);
    const double w = m == 0 ? 0.0 : -0.5 * std::sqrt((l - of_m - 1.0) * (l - of_m) / d);
    // Where a factor is zero its term may lie outside the band below.
    double sum = 0.0;
    if (u != 0.0) sum += u * p(0, m, n);
    if (v != 0.0) sum += v * term_v(m, n);
    if (w != 0.0) sum += w * term_w(m, n);
    return sum;
  }
  [[nodiscard]] double term_v(int m, int n) const {
    if (m == 0) return p(1, 1, n) + p(-1, -1, n);
    const double root = std::sqrt(2.0);
    if (m > 0) return m == 1 ? root * p(1, 0, n) : p(1, m - 1, n) - p(-1, -m + 1, n);
    return m == -1 ? root * p(-1, 0, n) : p(1, m + 1, n) + p(-1, -m - 1, n);
  }
  [[nodiscard]] double term_w(int m, int n) const {
    return m > 0 ? p(1, m + 1, n) + p(-1, -m - 1, n) : p(1, m - 1, n) - p(-1, -m + 1, n);
  }
  [[nodiscard]] double p(int i, int a, int n) const {
    if (n == l_) return r(i, 1) * of(a, l_ - 1) - r(i, -1) * of(a, -l_ + 1);
    if (n == -l_) return r(i, 1) * of(a, -l_ + 1) + r(i, -1) * of(a, l_ - 1);
    return r(i, 0) * of(a, n);
  }
  [[nodiscard]] double r(int i, int j) const { return first_(i + 1, j + 1); }
  [[nodiscard]] double of(int a, int b) const { return below_(a + l_ - 1, b + l_ - 1); }

  int l_;
  const MatrixD& first_;
  const MatrixD& below_;
};

/// Odd m change sign with the Condon–Shortley phase.
void apply_phase(MatrixD& band) {
  const Eigen::Index l = band.rows() / 2;
  for (Eigen::Index m = 0; m < band.rows(); ++m) {
    for (Eigen::Index n = 0; n < band.cols(); ++n) {
      if ((m - l + n - l) % 2 != 0) band(m, n) = -band(m, n);
    }
  }
}

}  // namespace

ShRotation::ShRotation(int order, const Eigen::Matrix3d& rotation) {
  constexpr std::array<int, 3> kAxes = {1, 2, 0};  // m = −1, 0, 1 are y, z, x
  MatrixD first(3, 3);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      first(i, j) =
          rotation(kAxes[static_cast<std::size_t>(i)], kAxes[static_cast<std::size_t>(j)]);
    }
  }
  bands_.push_back(MatrixD::Ones(1, 1));
  if (order > 1) bands_.push_back(first);
  for (int l = 2; l < order; ++l) bands_.push_back(RotationBand(l, first, bands_.back()).make());
  for (MatrixD& band : bands_) apply_phase(band);
}

MatrixD ShRotation::apply(const MatrixD& coefficients) const {
  MatrixD rotated(coefficients.rows(), coefficients.cols());
  Eigen::Index first = 0;
  for (const MatrixD& band : bands_) {
    rotated.middleRows(first, band.rows()).noalias() =
        band * coefficients.middleRows(first, band.rows());
    first += band.rows();
  }
  return rotated;
}

std::vector<double> lambert_bands(int order) {
  std::vector<double> bands(static_cast<std::size_t>(order), 0.0);
  double ratio = 1.0;  // l! / (2^l (l/2)!²)
  double sign = -1.0;
  for (int l = 0; l < order; ++l) {
    if (l % 2 == 1) {
      if (l == 1) bands[1] = 2.0 * kPiD / 3.0;
      continue;
    }
    if (l > 0) ratio *= (l - 1.0) / l;
    bands[static_cast<std::size_t>(l)] = 2.0 * kPiD * sign / ((l + 2.0) * (l - 1.0)) * ratio;
    sign = -sign;
  }
  return bands;
}

VectorD lambert_sh(int order, const Vec3d& normal) {
  MatrixD values = evaluate_sh(order, normal);
  scale_bands(lambert_bands(order), values);
  return values.col(0);
}

std::vector<double> hann_bands(int order, double width) {
  std::vector<double> bands(static_cast<std::size_t>(order), 1.0);
  if (!(width > 0.0)) return bands;
  for (int l = 0; l < order; ++l) {
    bands[static_cast<std::size_t>(l)] = l < width ? 0.5 * (1.0 + std::cos(kPiD * l / width)) : 0.0;
  }
  return bands;
}

void scale_bands(std::span<const double> bands, MatrixD& coefficients) {
  for (std::size_t l = 0; l < bands.size(); ++l) {
    const auto first = static_cast<Eigen::Index>(l * l);
    coefficients.middleRows(first, static_cast<Eigen::Index>(2 * l + 1)) *= bands[l];
  }
}

VectorD band_energy(int order, const MatrixD& coefficients) {
  VectorD energy(order);
  for (int l = 0; l < order; ++l) {
    energy[l] = coefficients.middleRows(sh_index(l, -l), 2 * l + 1).squaredNorm();
  }
  return energy;
}

namespace {

struct LegendreNode {
  double z, weight;
};

/// Gauss–Legendre nodes on [−1, 1] by Newton's method on P_n.
std::vector<LegendreNode> legendre_nodes(int n) {
  std::vector<LegendreNode> nodes;
  for (int i = 0; i < n; ++i) {
    double z = std::cos(kPiD * (i + 0.75) / (n + 0.5));
    double slope = 1.0;
    for (int step = 0; step < 20; ++step) {
      double below = 0.0;
      double value = 1.0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * z * value - (k - 1.0) * below) / k;
        below = value;
        value = next;
      }
      slope = n * (z * value - below) / (z * z - 1.0);
      z -= value / slope;
    }
    nodes.push_back({z, 2.0 / ((1.0 - z * z) * slope * slope)});
  }
  return nodes;
}

Vec3d at_height(double z, double phi) {
  const double sine = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {sine * std::cos(phi), sine * std::sin(phi), z};
}

/// SH eq. 21, where cos θ = cos(2 acos √(1 − u)) = 1 − 2u.
Vec3d at_square(double u, double v) { return at_height(1.0 - 2.0 * u, 2.0 * kPiD * v); }

}  // namespace

SphereQuadrature exact_quadrature(int order) {
  SphereQuadrature quadrature;
  const int around = 2 * order - 1;
  for (const LegendreNode& node : legendre_nodes(order)) {
    for (int k = 0; k < around; ++k) {
      quadrature.directions.push_back(at_height(node.z, 2.0 * kPiD * k / around));
      quadrature.weights.push_back(node.weight * 2.0 * kPiD / around);
    }
  }
  return quadrature;
}

SphereQuadrature stratified_quadrature(int side, std::uint64_t stream) {
  SphereQuadrature quadrature;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      Random random(stream, static_cast<std::uint64_t>(i * side + j));
      const double u = (i + static_cast<double>(random.uniform())) / side;
      const double v = (j + static_cast<double>(random.uniform())) / side;
      quadrature.directions.push_back(at_square(u, v));
    }
  }
  quadrature.weights.assign(quadrature.directions.size(), 4.0 * kPiD / (side * side));
  return quadrature;
}

SphereQuadrature equal_area_quadrature(int side) {
  SphereQuadrature quadrature;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      quadrature.directions.push_back(at_square((i + 0.5) / side, (j + 0.5) / side));
    }
  }
  quadrature.weights.assign(quadrature.directions.size(), 4.0 * kPiD / (side * side));
  return quadrature;
}

MatrixD project_sh(int order, const SphereQuadrature& quadrature,
                   const std::function<Vec3d(const Vec3d& direction)>& f) {
  MatrixD coefficients = MatrixD::Zero(sh_count(order), 3);
  for (std::size_t i = 0; i < quadrature.directions.size(); ++i) {
    const Vec3d& d = quadrature.directions[i];
    coefficients += evaluate_sh(order, d) * (quadrature.weights[i] * f(d)).transpose();
  }
  return coefficients;
}

}  // namespace prt
