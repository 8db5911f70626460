// The player's oracle: interprets a package's program on the CPU (Leonhardt & Bohn, §5). Every
// other back end is judged by what it says.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "domains/splats.h"
#include "package/package.h"
#include "scene/light.h"

namespace prt {

struct PlayerSettings {
  int area_samples = 25;  ///< points on each area light; square numbers are stratified both ways
  unsigned threads = 0;   ///< 0: all; results do not depend on it
};

/// Visibility of a light at a sample that it shines on from behind, or not at all (no light does in
/// a package for environments alone): no value, and no part in interpolation.
inline constexpr float kUnlit = -1.0F;

/// Irradiance at all n samples under some lights, W/m², linear in the lights, not clamped.
struct SampleIrradiance {
  std::vector<Light> lights;
  MatrixF direct;    ///< n × 3: straight from lights
  MatrixF sky;       ///< n × 3: straight from the environment; empty where the program takes none
  MatrixF indirect;  ///< n × 3: all that the program adds to those two
  /// Per light, n entries: share of its unshadowed irradiance that arrives, in [0, 1], or kUnlit.
  std::vector<std::vector<float>> visibility;

  // The evaluator's own, kept so that the next light change allocates nothing.
  std::uint64_t evaluator = 0;                   ///< number of the one whose result it is
  std::vector<std::vector<Vec2f>> light_points;  ///< places on each light that shine
  MatrixF direct_light;                          ///< 3 × n, before the program
  std::vector<MatrixF> work;
};

/// A point of a surface to light.
struct PlayPoint {
  Vec3f position;
  Vec3f normal;  ///< unit geometric normal on the side that is lit
  Vec3f
      shading_normal;  ///< unit; only shapes the cosine of direct light. Elsewhere: same as normal
};

/// Irradiance at a point, W/m², not clamped.
struct PlayedIrradiance {
  Vec3f direct = Vec3f::Zero();  ///< straight from lights and environment
  Vec3f indirect = Vec3f::Zero();
  float visibility = kUnlit;  ///< of the first light
  bool reached = false;       ///< false: no splat reaches the point, and all else is zero
};

class Evaluator {
 public:
  /// Lays out what lights ask for most and refers to the rest: the package must outlive the
  /// evaluator and stay as it is. Its scene is not looked at. Expects what validate() lets through.
  explicit Evaluator(const Package& package, const PlayerSettings& settings = {});
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  /// Runs the program. Twice the intensity gives exactly twice the irradiance, no light exactly
  /// zero. `environment`: radiance from infinitely far away as real spherical harmonics,
  /// W/(m² sr), 3 × order² (environment_order() of the package; player/environment_light.h makes
  /// them), or empty for none; std::invalid_argument for another order. Lights in a package without
  /// a direct_light step, and an environment in one that takes none, do nothing.
  [[nodiscard]] SampleIrradiance evaluate(std::span<const Light> lights,
                                          const MatrixF& environment = {}) const;
  /// The same into a result of before: with as many lights and one thread nothing is allocated, and
  /// of this evaluator and the same lights, only what hangs on the environment is computed again.
  void evaluate(std::span<const Light> lights, const MatrixF& environment,
                SampleIrradiance& result) const;

  /// What the program makes of direct irradiance that is given instead of played: n × 3 in,
  /// indirect irradiance n × 3 out, W/m². It tells errors of direct light from those of transfer.
  [[nodiscard]] MatrixF respond(const MatrixF& direct) const;

  /// Share of one light that arrives at each of the n samples, in [0, 1], or kUnlit: the soft test
  /// that visibility_error judges (design: what "error" means), for point lights.
  [[nodiscard]] std::vector<float> visibility(const Light& light) const;

  /// Light at any surface points, as many as points: direct light by its own distance and angle
  /// times visibility interpolated from the samples, indirect light interpolated.
  [[nodiscard]] std::vector<PlayedIrradiance> reconstruct(const SampleIrradiance& irradiance,
                                                          std::span<const PlayPoint> points) const;

  [[nodiscard]] const Package& package() const { return package_; }
  [[nodiscard]] const SplatField& splats() const { return splats_; }

 private:
  struct Tables;
  /// Direct light at the samples, before the program.
  void set_lights(std::span<const Light> lights, SampleIrradiance& result) const;

  const Package& package_;
  PlayerSettings settings_;
  SplatField splats_;
  std::unique_ptr<const Tables> tables_;
};

}  // namespace prt
