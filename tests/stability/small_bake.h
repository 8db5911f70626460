// A whole bake of a small scene in this process, and the light that its package plays.
#pragma once

#include <cmath>
#include <memory>
#include <utility>

#include "methods/lb/lb.h"
#include "player/evaluator.h"
#include "support/partial_bake.h"

namespace prt::test {

/// Options of a bake that takes about a second.
inline OptionValues small_options() {
  OptionValues options = default_options(lb_method());
  options.set("samples.count", 1200);
  options.set("samples.cluster_size", 200);
  options.set("rays.directions", 256);
  options.set("lb.example_lights", 200);
  options.set("lb.photons", 20000);
  return options;
}

class SmallBake {
 public:
  explicit SmallBake(Scene scene, const OptionValues& options = small_options())
      : scene_(std::make_unique<Scene>(std::move(scene))), bake_(*scene_, options) {
    plan_ = bake_.run(lb_method());
    package_ =
        lb_method().assemble([this](const std::string& id) { return bake_.result(id); }, options);
    player_ = std::make_unique<Evaluator>(package_);
  }

  [[nodiscard]] SampleIrradiance light(const Light& light) const {
    return player_->evaluate({&light, 1});
  }
  [[nodiscard]] SampleIrradiance light(const Vec3f& position) const {
    Light point;
    point.position = position;
    return light(point);
  }
  [[nodiscard]] const Evaluator& player() const { return *player_; }
  [[nodiscard]] const Scene& scene() const { return *scene_; }
  [[nodiscard]] const SampleSet& samples() const { return package_.samples; }
  [[nodiscard]] const Package& package() const { return package_; }
  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] const InProcessBake& bake() const { return bake_; }

  /// Flux through the samples' cells, W, first channel.
  [[nodiscard]] double flux(const MatrixF& irradiance) const {
    double sum = 0.0;
    for (std::size_t s = 0; s < samples().size(); ++s) {
      sum += samples().areas[s] * irradiance(static_cast<Eigen::Index>(s), 0);
    }
    return sum;
  }
  /// Mean irradiance over the samples that `inside` holds for.
  template <typename Inside>
  [[nodiscard]] double mean(const MatrixF& irradiance, Inside&& inside) const {
    double sum = 0.0;
    double area = 0.0;
    for (std::size_t s = 0; s < samples().size(); ++s) {
      if (!inside(samples().positions[s], samples().normals[s])) continue;
      sum += samples().areas[s] * irradiance(static_cast<Eigen::Index>(s), 0);
      area += samples().areas[s];
    }
    return area > 0.0 ? sum / area : NAN;
  }

 private:
  std::unique_ptr<Scene> scene_;  // the bake refers to it
  InProcessBake bake_;
  Plan plan_;
  Package package_;
  std::unique_ptr<Evaluator> player_;
};

}  // namespace prt::test
