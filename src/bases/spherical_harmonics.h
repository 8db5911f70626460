// Real spherical harmonics (Slomp, Oliveira & Patrício, "A Gentle Introduction to Precomputed
// Radiance Transfer", §4; SH below), with the tutorial's signs: the Condon–Shortley phase is in the
// Legendre functions.
//
// An order counts bands: order n has the bands 0 … n − 1 and n² functions, order 5 has 25. Function
// (l, m) is number l(l + 1) + m. The polar axis is +z of the frame that directions are given in.
//
// The tutorial's recursion multiplies up double factorials and divides by factorials again
// (§6.2.2): both leave the range of float from band 17 on, and powers of sin θ cancel near the
// poles. Here normalised functions come from three-term recurrences in double, and sin^m θ e^{imφ}
// is the polynomial (x + iy)^m: no factorial, no angle.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/types.h"

namespace prt {

/// Highest order that callers offer; the functions themselves know no limit.
inline constexpr int kMostShOrder = 8;

constexpr int sh_count(int order) { return order * order; }
constexpr int sh_index(int band, int m) { return band * (band + 1) + m; }

/// All functions of an order at a unit direction: sh_count(order) values.
void evaluate_sh(int order, const Vec3d& direction, std::span<double> values);
VectorD evaluate_sh(int order, const Vec3d& direction);

/// The matrix D of a rotation R: Y(R d) = D Y(d) for every direction d. It is orthogonal and has a
/// block per band; all between bands is zero.
class ShRotation {
 public:
  /// `rotation`: proper and orthonormal, 3 × 3. Blocks by the recurrence of Ivanic & Ruedenberg
  /// (J. Phys. Chem. 1996, with the correction of 1998), in double.
  ShRotation(int order, const Eigen::Matrix3d& rotation);
  /// Coefficients of f(Rᵀ d) from those of f(d): sh_count(order) rows, any number of columns.
  [[nodiscard]] MatrixD apply(const MatrixD& coefficients) const;
  /// (2l + 1) × (2l + 1), m from −l to l.
  [[nodiscard]] const MatrixD& band(int l) const { return bands_[static_cast<std::size_t>(l)]; }

 private:
  std::vector<MatrixD> bands_;
};

/// Zonal coefficients A_l of the clamped cosine: ∫ max(0, n·d) Y_lm(d) dd = A_l Y_lm(n). Closed
/// form (Ramamoorthi & Hanrahan, "An Efficient Representation for Irradiance Environment Maps",
/// 2001): A_0 = π, A_1 = 2π/3, A_l = 0 for other odd l.
std::vector<double> lambert_bands(int order);

/// Unshadowed transfer (SH §6.2.6.1 without albedo, in closed form): irradiance on a surface of
/// unit normal n is the dot product with the light's coefficients.
VectorD lambert_sh(int order, const Vec3d& normal);

/// Hann window, (1 + cos(π l / width)) / 2 for l < width and else 0, per band: takes the ringing
/// from a light of few bands, and sharpness with it. Width 0: no window, all ones.
std::vector<double> hann_bands(int order, double width);
/// Multiplies the rows of each band.
void scale_bands(std::span<const double> bands, MatrixD& coefficients);

/// Σ_m c_lm² of each band, summed over the columns: what a rotation leaves as it is.
VectorD band_energy(int order, const MatrixD& coefficients);

/// Directions with solid angles: ∫ f ≈ Σ weights[i] f(directions[i]).
struct SphereQuadrature {
  std::vector<Vec3d> directions;
  std::vector<double> weights;
};
/// Gauss–Legendre in z, uniform around it: exact for products of two functions of the order.
SphereQuadrature exact_quadrature(int order);
/// side² directions, one at random in each cell of a square that covers the sphere (SH §5.2, eq. 20
/// and 21).
SphereQuadrature stratified_quadrature(int side, std::uint64_t stream);
/// The centres of those cells: side² directions of equal area.
SphereQuadrature equal_area_quadrature(int side);

/// Coefficients of f, one column per colour channel (SH eq. 18).
MatrixD project_sh(int order, const SphereQuadrature& quadrature,
                   const std::function<Vec3d(const Vec3d& direction)>& f);

}  // namespace prt
