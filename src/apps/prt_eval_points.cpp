#include "apps/prt_eval_points.h"

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <stdexcept>

#include "base/log.h"
#include "base/random.h"
#include "evaluate/points_csv.h"
#include "evaluate/reference.h"
#include "package/read.h"
#include "player/environment_light.h"
#include "player/evaluator.h"
#include "scene/embree/embree_ray_caster.h"
#include "scene/load.h"

namespace prt {
namespace {

void check_finite(const Vec3f& direct, const Vec3f& indirect, std::size_t point) {
  if (direct.allFinite() && indirect.allFinite()) return;
  throw std::runtime_error(fmt::format(
      "the irradiance at point {} is not finite; is a light exactly on it?", point + 1));
}

std::vector<PointIrradiance> played(const EvalCommand& command,
                                    const std::vector<WorldPoint>& points) {
  const Package package = read_package(command.input);
  const Vec3d& origin = package.scene.origin;
  const Evaluator player(package);
  std::vector<PlayPoint> asked;
  for (const ReceiverPoint& p : points_in(origin, points)) {
    asked.push_back({p.position, p.normal, p.normal});
  }
  MatrixF sky;
  if (!command.environments.empty()) {
    require_environment(package, command.input.string());
    sky = EnvironmentLight(parse_environment(command.environments[0]), environment_order(package))
              .coefficients();
  }
  if (!command.point_lights.empty()) require_direct_light(package, command.input.string());
  const auto light =
      player.reconstruct(player.evaluate(lights_in(origin, command.point_lights), sky), asked);
  std::vector<PointIrradiance> values;
  std::size_t unreached = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (light[i].reached) {
      check_finite(light[i].direct, light[i].indirect, i);
      values.push_back({light[i].direct, light[i].indirect});
    } else {
      const Vec3f unknown = Vec3f::Constant(std::numeric_limits<float>::quiet_NaN());
      values.push_back({unknown, unknown});
      ++unreached;
    }
  }
  if (unreached > 0) {
    log::warn("{} of {} points are farther from every sample than its splat reaches: nan",
              unreached, points.size());
  }
  return values;
}

std::vector<PointIrradiance> traced(const EvalCommand& command,
                                    const std::vector<WorldPoint>& points) {
  const Scene scene = load_scene(command.input);
  const auto caster = make_embree_ray_caster(scene);
  std::optional<Environment> sky;
  if (!command.environments.empty()) sky = parse_environment(command.environments[0]);
  const auto estimates =
      trace_in_parallel(scene, *caster, lights_in(scene.origin, command.point_lights),
                        points_in(scene.origin, points),
                        {.paths = command.paths, .environment = sky ? &*sky : nullptr},
                        stream_key(command.seed, "reference at points"), 0, [] {});
  std::vector<PointIrradiance> values;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    values.push_back({estimates[i].mean_direct(), estimates[i].mean_indirect()});
    check_finite(values.back().direct, values.back().indirect, i);
  }
  return values;
}

}  // namespace

void evaluate_points(const EvalCommand& command) {
  const std::vector<WorldPoint> points = read_points_csv(command.points);
  const bool play = command.form == EvalCommand::Form::kPlayPoints;
  write_points_csv(command.output, points,
                   play ? played(command, points) : traced(command, points));
}

}  // namespace prt
